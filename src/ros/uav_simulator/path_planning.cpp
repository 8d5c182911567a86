// SPDX-License-Identifier: BSD-3-Clause
// The MRS service trajectory_generation: paths become trajectories that continue what the vehicle is about to fly.
#include <algorithm>
#include <cmath>

#include "commands.hpp"
#include "messages.hpp"
#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav_simulation::HeadedPoint;
using voxnav_simulation::KinematicState;
using voxnav_simulation::PathRequest;
using voxnav_simulation::TrackerAxisLimits;
using voxnav_simulation::TrackerLimits;

constexpr double kFuture_s = 0.2;  ///< a path stamped farther ahead than this continues the prediction

/// Overrides can only narrow the constraints in force, which the tracker keeps in any case. Values that are not
/// positive are ignored.
void narrow(TrackerAxisLimits* limits, double speed, double acceleration, double jerk) {
  const auto lower = [](double* value, double wanted) {
    if (wanted > 0) *value = std::min(*value, wanted);
  };
  lower(&limits->speed, speed);
  lower(&limits->acceleration, acceleration);
  lower(&limits->jerk, jerk);
}

void apply_overrides(const mrs_msgs::Path& path, TrackerLimits* limits) {
  if (!path.override_constraints) return;
  narrow(&limits->horizontal, path.override_max_velocity_horizontal, path.override_max_acceleration_horizontal,
         path.override_max_jerk_horizontal);
  for (TrackerAxisLimits* vertical : {&limits->ascending, &limits->descending}) {
    narrow(vertical, path.override_max_velocity_vertical, path.override_max_acceleration_vertical,
           path.override_max_jerk_vertical);
  }
}

mrs_msgs::Reference to_reference(const HeadedPoint& point) {
  mrs_msgs::Reference out;
  out.position = to_msg(point.position);
  out.heading = point.heading_rad;
  return out;
}

}  // namespace

/// Decides where the trajectory begins: in the present state, or for a path from the future in the prediction at half
/// of that time, with the samples of the prediction up to there in front of it.
void UavCommands::set_start(const mrs_msgs::Path& path, PathRequest* request, Plan* out) {
  const std::lock_guard<std::mutex> lock(*shared_.mutex);
  voxnav_simulation::Uav& uav = *shared_.uav;
  out->stamp = to_ros(uav.stamp_ns());
  request->limits = uav.tracker().limits();
  apply_overrides(path, &request->limits);
  if (path.dont_prepend_current_state) return;
  request->start = uav.tracker().state();
  const double ahead_s = (path.header.stamp - out->stamp).toSec();
  if (path.header.stamp.isZero() || ahead_s <= kFuture_s) return;
  const auto count = std::max(1, static_cast<int>(std::ceil((0.5 * ahead_s - 0.01) / 0.2)));
  if (count >= uav_messages::kNumPredicted) return;  // the prediction ends before; the present state is the start
  for (int i = 0; i < count; ++i) {
    const KinematicState& s = uav.predicted(uav_messages::predicted_ahead_s(i));
    out->front.push_back({s.position, s.heading_rad});
  }
  request->start = uav.predicted(uav_messages::predicted_ahead_s(count));
  out->has_dropped_waypoint = request->waypoints.size() > 1;
  if (out->has_dropped_waypoint) request->waypoints.erase(request->waypoints.begin());
}

UavCommands::Plan UavCommands::plan(const mrs_msgs::Path& path, const voxnav::geometry::Pose& T_O_path) {
  PathRequest request;
  for (const auto& point : path.points) {
    request.waypoints.push_back(transformed(T_O_path, {from_msg(point.position), point.heading}));
  }
  request.max_deviation_m = path.max_deviation_from_path;
  request.use_heading = path.use_heading;
  request.stop_at_waypoints = path.stop_at_waypoints;
  request.is_loop = path.loop;
  request.has_heading_of_motion = path.override_heading_atan2;
  request.has_relaxed_heading = path.relax_heading;
  Plan out;
  set_start(path, &request, &out);
  voxnav_simulation::TrajectoryGeneratorConfig config = config_.generator;
  if (!out.front.empty()) config.sampling_s = 0.2;  // as in the prediction, which comes first
  out.generated = generate_trajectory(config, request);
  return out;
}

void UavCommands::get_path(const mrs_msgs::Path& path, mrs_msgs::GetPathSrv::Response* response) {
  response->success = false;
  const auto T_O_path = frames_.T_O(path.header.frame_id);
  if (!T_O_path) {
    response->message = "no transform from '" + path.header.frame_id + "' to the control frame";
    return;
  }
  const Plan planned = plan(path, *T_O_path);
  response->message = planned.generated.message;
  if (!planned.generated.is_valid) return;
  const voxnav::geometry::Pose T_path_O = T_O_path->inverse();
  mrs_msgs::TrajectoryReference& out = response->trajectory;
  out.header.frame_id = path.header.frame_id.empty() ? frames_.control() : path.header.frame_id;
  out.header.stamp = planned.stamp;
  out.input_id = path.input_id;
  out.use_heading = path.use_heading || path.override_heading_atan2;
  out.fly_now = path.fly_now;
  out.loop = path.loop;
  out.dt = planned.generated.dt_s;
  for (const HeadedPoint& point : planned.front) out.points.push_back(to_reference(transformed(T_path_O, point)));
  for (const HeadedPoint& point : planned.generated.samples) {
    out.points.push_back(to_reference(transformed(T_path_O, point)));
  }
  const auto offset = static_cast<std::int64_t>(planned.front.size());
  if (planned.has_dropped_waypoint) response->waypoint_trajectory_idxs.push_back(offset);
  for (const std::size_t sample : planned.generated.waypoint_samples) {
    response->waypoint_trajectory_idxs.push_back(offset + static_cast<std::int64_t>(sample));
  }
  response->success = true;
  response->message =
      planned.generated.stops_at_corners ? "trajectory generated, it stops at corners" : "trajectory generated";
}

}  // namespace voxnav_ros
