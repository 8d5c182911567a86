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

void LocalMapperNodelet::watch_load(double work_s, const pipeline::MapperStep& step) {
  work_s_ += work_s;
  if (!step.leads) return;
  const ros::Time stamp = to_ros(step.stamp_ns);
  if (!last_inserted_.isZero()) mapper_->add_load(work_s_, (stamp - last_inserted_).toSec());
  last_inserted_ = stamp;
  work_s_ = 0.0;
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
  diagnostics().set_counter("moving_not_followed", static_cast<double>(mapper_->moving().num_not_followed()));
  diagnostics().set_counter("new_voxels_not_kept", static_cast<double>(mapper_->map().num_new_not_kept()));
  diagnostics().set_counter("moving_voxels_not_kept", static_cast<double>(mapper_->map().num_moving_not_kept()));
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

void LocalMapperNodelet::drop(MapperSensor* sensor, const ros::Time& stamp, const std::string& reason) {
  ++sensor->num_dropped;
  report(*sensor);
  diagnostics().add_dropped("insert");
  diagnostics().set_counter("scans_late", static_cast<double>(num_late_));
  warn("scan dropped: " + sensor->name + ": " + reason);
  publish_progress(stamp, sensor->progress_part);
}

void LocalMapperNodelet::report(const MapperSensor& sensor) {
  const auto count = [&](const char* what, std::uint64_t value) {
    diagnostics().set_counter(sensor.name + "/" + what, static_cast<double>(value));
  };
  count("scans_mapped", sensor.num_mapped);
  count("scans_dropped", sensor.num_dropped);
  count("scans_late", sensor.num_late);
  count("scans_surplus", sensor.num_surplus);
}

/// A sensor that died is said for as long as others deliver, but for the time in which another warning stands; it costs
/// them nothing.
void LocalMapperNodelet::watch_silence() {
  const std::vector<std::string> silent = silent_sensors(sensors_, clock().now_s());
  diagnostics().set_counter("sensors_silent", static_cast<double>(silent.size()));
  std::string text;
  for (const std::string& each : silent) text += (text.empty() ? "" : "; ") + each;
  if (!text.empty() && ros::SteadyTime::now() > warned_ + ros::WallDuration(kWarningHold_s)) warn(text);
}

/// Warns if beams without return shall clear space but none arrive, since nothing else would show why the sky stays
/// unknown.
void LocalMapperNodelet::warn_of_missing_beams(const MapperSensor& sensor, const pipeline::SensorConfig& limits,
                                               const sensor_msgs::PointCloud2& msg) {
  const occupancy::LocalMapConfig& map = mapper_->map().config();
  const auto is_beam = [](const sensor_msgs::PointField& field) { return field.name == "beam_x"; };
  const double range_m = std::min(map.no_return_range_m, limits.no_return_range_m);
  if (range_m < map.resolution_m || std::any_of(msg.fields.begin(), msg.fields.end(), is_beam)) return;
  warn("map/no_return_range_m is set, but the clouds of " + sensor.name +
       " say nothing of open beams: set open_beams/is_enabled of its cloud_filter, or " + sensor.name +
       "/no_return_range_m to 0");
}

void LocalMapperNodelet::warn(const std::string& text) {
  warned_ = ros::SteadyTime::now();
  diagnostics().set_level(msg::NodeDiagnostics::WARN, text);
  NODELET_WARN_STREAM_THROTTLE(kLogPeriod_s, "[" << node() << "]: " << text);
}

}  // namespace voxnav_ros
