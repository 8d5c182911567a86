// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>

#include "local_mapper_nodelet.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

// Faults around the local map, and how they are reported.

namespace voxnav_ros {
namespace {

constexpr double kLogPeriod_s = 5.0;
/// How long a warning stays, which is longer than the period of diagnostics, so that the next good scan does not hide
/// it.
constexpr double kWarningHold_s = 2.0;

}  // namespace

void LocalMapperNodelet::watch_load(double work_s, const ros::Time& stamp) {
  if (!last_inserted_.isZero()) mapper_->add_load(work_s, (stamp - last_inserted_).toSec());
  last_inserted_ = stamp;
  diagnostics().set_counter("decimation", mapper_->decimation());
  if (mapper_->decimation() > 1) {
    warn("overloaded: every " + std::to_string(mapper_->decimation()) + "th point of a scan is used");
  }
}

void LocalMapperNodelet::report(const occupancy::InsertStatistics& s) {
  diagnostics().set_counter("points_not_finite", static_cast<double>(num_not_finite_ += s.rejected_not_finite));
  diagnostics().set_counter("points_too_near", static_cast<double>(num_too_near_ += s.rejected_too_near));
  diagnostics().set_counter("points_far", static_cast<double>(num_far_ += s.far));
  diagnostics().set_counter("cells_hit", static_cast<double>(s.cells_hit));
  diagnostics().set_counter("cells_missed", static_cast<double>(s.cells_missed));
  diagnostics().set_counter("cells_freed", static_cast<double>(s.cells_freed));
  diagnostics().set_counter("blocks_evicted_dropped", static_cast<double>(mapper_->map().num_evicted_dropped()));
  diagnostics().set_counter("map_mb", static_cast<double>(mapper_->map().memory_bytes()) * 1e-6);
  if (ros::SteadyTime::now() > warned_ + ros::WallDuration(kWarningHold_s)) {
    diagnostics().set_level(msg::NodeDiagnostics::OK, "");
  }
}

/// Hands over the content of the map before it is cleared.
void LocalMapperNodelet::restart(const std::string& reason, const std::string& text) {
  hand_over(mapper_->clear(reason));
  report_clear(text);
}

void LocalMapperNodelet::report_clear(const std::string& text) {
  diagnostics().set_counter("map_clears", static_cast<double>(++num_clears_));
  warn("map cleared: " + text);
}

void LocalMapperNodelet::drop(const ros::Time& stamp, const std::string& reason) {
  diagnostics().add_dropped("insert");
  diagnostics().set_counter("scans_late", static_cast<double>(num_late_));
  warn("scan dropped: " + reason);
  publish_progress(stamp);
}

/// Warns if beams without return shall clear space but none arrive, since nothing else would show why the sky stays
/// unknown.
void LocalMapperNodelet::warn_of_missing_beams(const sensor_msgs::PointCloud2& msg) {
  const occupancy::LocalMapConfig& map = mapper_->map().config();
  const auto is_beam = [](const sensor_msgs::PointField& field) { return field.name == "beam_x"; };
  if (map.no_return_range_m < map.resolution_m || std::any_of(msg.fields.begin(), msg.fields.end(), is_beam)) return;
  warn("map/no_return_range_m is set, but clouds say nothing of open beams: set open_beams/is_enabled of cloud_filter");
}

void LocalMapperNodelet::warn(const std::string& text) {
  warned_ = ros::SteadyTime::now();
  diagnostics().set_level(msg::NodeDiagnostics::WARN, text);
  NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
}

}  // namespace voxnav_ros
