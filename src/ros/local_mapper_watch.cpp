// SPDX-License-Identifier: BSD-3-Clause
#include "local_mapper_nodelet.hpp"
#include "voxnav_ros/conversions.hpp"

// What goes wrong around the map, and what is said of it.

namespace voxnav_ros {
namespace {

constexpr double kLogPeriod_s = 5.0;
/// Longer than the period of diagnostics, so that the next good scan does not hide a warning.
constexpr double kWarningHold_s = 2.0;

}  // namespace

void LocalMapperNodelet::watch_load(double work_s, const ros::Time& stamp) {
  if (!last_inserted_.isZero()) load_->add(work_s, (stamp - last_inserted_).toSec());
  last_inserted_ = stamp;
  diagnostics().set_counter("decimation", load_->decimation());
  if (load_->decimation() > 1) {
    warn("overloaded: every " + std::to_string(load_->decimation()) + "th point of a scan is used");
  }
}

void LocalMapperNodelet::report(const occupancy::InsertStatistics& s) {
  diagnostics().set_counter("points_not_finite", static_cast<double>(num_not_finite_ += s.rejected_not_finite));
  diagnostics().set_counter("points_too_near", static_cast<double>(num_too_near_ += s.rejected_too_near));
  diagnostics().set_counter("points_far", static_cast<double>(num_far_ += s.far));
  diagnostics().set_counter("cells_hit", static_cast<double>(s.cells_hit));
  diagnostics().set_counter("cells_missed", static_cast<double>(s.cells_missed));
  diagnostics().set_counter("cells_freed", static_cast<double>(s.cells_freed));
  diagnostics().set_counter("blocks_evicted_dropped", static_cast<double>(map_->num_evicted_dropped()));
  diagnostics().set_counter("map_mb", static_cast<double>(map_->memory_bytes()) * 1e-6);
  if (ros::SteadyTime::now() > warned_ + ros::WallDuration(kWarningHold_s)) {
    diagnostics().set_level(voxnav::NodeDiagnostics::OK, "");
  }
}

/// Hands everything over before it is forgotten.
void LocalMapperNodelet::restart(const std::string& reason, const std::string& text) {
  hand_over(scheduler_->finish(map_.get(), reason));
  map_->clear();
  last_body_.reset();
  diagnostics().set_counter("map_clears", static_cast<double>(++num_clears_));
  warn("map cleared: " + text);
}

/// A late scan says nothing about now, and the map has newer ones: it is left out. Only when the scans after it confirm
/// that time jumped back is the map of the future forgotten.
bool LocalMapperNodelet::watch_clock(const ros::Time& stamp) {
  using Verdict = voxnav::base::ClockWatch::Verdict;
  const auto newest_ns = clock_.newest_ns();
  const Verdict verdict = clock_.add(to_ns(stamp));
  if (verdict == Verdict::kNext) return true;
  const std::string from = std::to_string(voxnav::base::to_seconds(*newest_ns));
  if (verdict == Verdict::kNewClock) {
    restart("odometry", "time jumped back from " + from + " to " + std::to_string(stamp.toSec()));
    return true;
  }
  diagnostics().set_counter("scans_late", static_cast<double>(++num_late_));
  drop(stamp, "its stamp is not newer than that of the scan before, " + from);
  return false;
}

void LocalMapperNodelet::watch_jump(const voxnav::geometry::Pose& T_O_B) {
  const voxnav::geometry::Vec3 now = T_O_B.translation();
  if (last_body_ && (now - *last_body_).norm() > config_.max_jump_m) {
    restart("odometry", "the pose jumped by " + std::to_string((now - *last_body_).norm()) + " m");
  }
  last_body_ = now;
}

void LocalMapperNodelet::drop(const ros::Time& stamp, const std::string& reason) {
  diagnostics().add_dropped("insert");
  warn("scan dropped: " + reason);
  publish_progress(stamp);
}

void LocalMapperNodelet::warn(const std::string& text) {
  warned_ = ros::SteadyTime::now();
  diagnostics().set_level(voxnav::NodeDiagnostics::WARN, text);
  NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
}

}  // namespace voxnav_ros
