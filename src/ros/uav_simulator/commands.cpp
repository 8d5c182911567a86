// SPDX-License-Identifier: BSD-3-Clause
#include "commands.hpp"

#include <mrs_msgs/TrajectoryReference.h>

#include <algorithm>
#include <cmath>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using voxnav_simulation::HeadedPoint;
using voxnav_simulation::ServiceTimes;
using voxnav_simulation::TrackedTrajectory;
using voxnav_simulation::TrackerMode;

constexpr double kDefaultDt_s = 0.2;
constexpr double kLogPeriod_s = 1.0;
constexpr double kMaxStandstill_s = 5.0;  ///< wall time after which a service no longer waits for simulated time

HeadedPoint from_msg(const mrs_msgs::Reference& reference) {
  return {voxnav_ros::from_msg(reference.position), reference.heading};
}

std::string no_transform(const std::string& frame, const UavFrames& frames) {
  return "no transform from '" + frame + "' to the control frame '" + frames.control() + "'";
}

}  // namespace

UavCommands::UavCommands(ros::NodeHandle& nh, const Shared& shared, UavFrames& frames, const Config& config,
                         std::function<std::string()> take_off_refusal)
    : shared_(shared), frames_(frames), config_(config), take_off_refusal_(std::move(take_off_refusal)) {
  voxnav::base::checked(config_.safety_area);
  advertise_triggers(nh);
  advertise_references(nh);
  advertise_trajectories(nh);
  advertise_others(nh);
  advertise_emergencies(nh);
  advertise_validation(nh);
}

void UavCommands::let_pass(Duration duration) {
  voxnav::base::StampNs until_ns = 0;
  const auto now_ns = [this] { return shared_.uav->stamp_ns(); };
  {
    const std::lock_guard<std::mutex> lock(*shared_.mutex);
    const voxnav::base::StampNs duration_ns = (shared_.service_times->*duration)();
    if (duration_ns == 0) return;
    until_ns = now_ns() + duration_ns;
  }
  const ros::WallTime begin = ros::WallTime::now();
  while (ros::ok()) {
    {
      const std::lock_guard<std::mutex> lock(*shared_.mutex);
      if (now_ns() >= until_ns) return;
    }
    if ((ros::WallTime::now() - begin).toSec() > kMaxStandstill_s) {
      ROS_WARN_THROTTLE(kLogPeriod_s, "[UavSimulator]: simulated time stands still, so a service answers at once");
      return;
    }
    ros::WallDuration(0.001).sleep();
  }
}

void UavCommands::trigger(ros::NodeHandle& nh, const std::string& name, const std::function<Result()>& command) {
  using Callback = boost::function<bool(Trigger::Request&, Trigger::Response&)>;
  services_.push_back(
      nh.advertiseService(name, Callback([this, command](Trigger::Request&, Trigger::Response& response) {
                            let_pass(&ServiceTimes::command_ns);
                            const std::lock_guard<std::mutex> lock(*shared_.mutex);
                            const Result result = command();
                            response.success = result.success;
                            response.message = result.message;
                            return true;
                          })));
}

void UavCommands::advertise_triggers(ros::NodeHandle& nh) {
  trigger(nh, "uav_manager/takeoff", [this] {
    const std::string refusal = take_off_refusal_();
    return refusal.empty() ? shared_.uav->take_off() : Result{false, refusal};
  });
  trigger(nh, "uav_manager/land", [this] { return shared_.uav->land(); });
  trigger(nh, "control_manager/hover", [this] { return shared_.uav->hover(); });
  trigger(nh, "control_manager/stop_trajectory_tracking", [this] { return stop_tracking(); });
  trigger(nh, "control_manager/start_trajectory_tracking", [this] { return start_tracking(); });
  trigger(nh, "control_manager/resume_trajectory_tracking", [this] { return resume_tracking(); });
  trigger(nh, "control_manager/goto_trajectory_start", [this] { return go_to_start(); });
  serve_string(nh, "constraint_manager/set_constraints",
               [this](const std::string& name) { return set_constraints(name); });
}

UavCommands::Result UavCommands::set_constraints(const std::string& name) {
  const auto set = voxnav::base::value_of_word<voxnav_simulation::ConstraintSet>(name);
  if (!set) return {false, "there are no constraints named '" + name + "', only slow, medium and fast"};
  shared_.uav->set_limits(limits_of(config_.constraints, *set));
  *shared_.constraints = *set;
  return {true, "constraints set to " + name};
}

void UavCommands::advertise_references(ros::NodeHandle& nh) {
  using Stamped = mrs_msgs::ReferenceStampedSrv;
  services_.push_back(nh.advertiseService("control_manager/reference",
                                          boost::function<bool(Stamped::Request&, Stamped::Response&)>(
                                              [this](Stamped::Request& request, Stamped::Response& response) {
                                                let_pass(&ServiceTimes::command_ns);
                                                const Result result = go_to(request.header, request.reference);
                                                response.success = result.success;
                                                response.message = result.message;
                                                return true;
                                              })));
  services_.push_back(nh.advertiseService(
      "control_manager/goto", boost::function<bool(mrs_msgs::Vec4::Request&, mrs_msgs::Vec4::Response&)>(
                                  [this](mrs_msgs::Vec4::Request& request, mrs_msgs::Vec4::Response& response) {
                                    let_pass(&ServiceTimes::command_ns);
                                    mrs_msgs::Reference reference;
                                    reference.position.x = request.goal[0];
                                    reference.position.y = request.goal[1];
                                    reference.position.z = request.goal[2];
                                    reference.heading = request.goal[3];
                                    const Result result = go_to(std_msgs::Header(), reference);
                                    response.success = result.success;
                                    response.message = result.message;
                                    return true;
                                  })));
  subscribers_.push_back(nh.subscribe<mrs_msgs::ReferenceStamped>(
      "control_manager/reference", 10, [this](const mrs_msgs::ReferenceStampedConstPtr& msg) {
        const Result result = go_to(msg->header, msg->reference);
        if (!result.success) ROS_WARN_STREAM("[UavSimulator]: reference refused: " << result.message);
      }));
}

UavCommands::Result UavCommands::go_to(const std_msgs::Header& header, const mrs_msgs::Reference& reference) {
  const auto T_O_frame = frames_.T_O(header.frame_id);
  if (!T_O_frame) return {false, no_transform(header.frame_id, frames_)};
  const std::lock_guard<std::mutex> lock(*shared_.mutex);
  return go_to(transformed(*T_O_frame, from_msg(reference)));
}

UavCommands::Result UavCommands::go_to(const HeadedPoint& goal_O) {
  // As in MRS, what is not finite is refused as such, before the safety area is asked.
  if (is_finite(goal_O) && !is_inside(config_.safety_area, goal_O.position)) {
    return {false, "failed to set the reference, the point is outside of the safety area!"};
  }
  return shared_.uav->go_to(goal_O);
}

void UavCommands::advertise_trajectories(ros::NodeHandle& nh) {
  using Fly = mrs_msgs::TrajectoryReferenceSrv;
  services_.push_back(nh.advertiseService(
      "control_manager/trajectory_reference",
      boost::function<bool(Fly::Request&, Fly::Response&)>([this](Fly::Request& request, Fly::Response& response) {
        let_pass(&ServiceTimes::command_ns);
        const auto [result, is_modified] = fly(request.trajectory);
        response.success = result.success;
        response.message = result.message;
        response.modified = is_modified;
        response.tracker_names = {"MpcTracker"};
        response.tracker_successes = {static_cast<std::uint8_t>(result.success)};
        response.tracker_messages = {result.message};
        return true;
      })));
  subscribers_.push_back(nh.subscribe<mrs_msgs::TrajectoryReference>(
      "control_manager/trajectory_reference", 10, [this](const mrs_msgs::TrajectoryReferenceConstPtr& msg) {
        const Result result = fly(*msg).result;
        if (!result.success) ROS_WARN_STREAM("[UavSimulator]: trajectory refused: " << result.message);
      }));
  using Get = mrs_msgs::GetPathSrv;
  services_.push_back(nh.advertiseService(
      "trajectory_generation/get_path",
      boost::function<bool(Get::Request&, Get::Response&)>([this](Get::Request& request, Get::Response& response) {
        get_path(request.path, &response);
        let_pass(&ServiceTimes::generator_ns);
        return true;
      })));
  using Path = mrs_msgs::PathSrv;
  services_.push_back(nh.advertiseService(
      "trajectory_generation/path",
      boost::function<bool(Path::Request&, Path::Response&)>([this](Path::Request& request, Path::Response& response) {
        Get::Response generated;
        get_path(request.path, &generated);
        let_pass(&ServiceTimes::generator_ns);
        response.success = generated.success;
        response.message = generated.message;
        if (!generated.success) return true;
        const Result result = fly(generated.trajectory).result;
        response.success = result.success;
        response.message = result.message;
        return true;
      })));
}

UavCommands::Flown UavCommands::fly(const mrs_msgs::TrajectoryReference& msg) {
  const auto T_O_frame = frames_.T_O(msg.header.frame_id);
  if (!T_O_frame) return {{false, no_transform(msg.header.frame_id, frames_)}};
  TrackedTrajectory trajectory;
  for (const auto& point : msg.points) trajectory.points.push_back(transformed(*T_O_frame, from_msg(point)));
  const auto& points = trajectory.points;
  if (!std::all_of(points.begin(), points.end(), [](const HeadedPoint& point) { return is_finite(point); })) {
    return {{false, "the trajectory contains a value that is not finite"}};
  }
  trajectory.dt_s = msg.dt <= 1e-4 ? kDefaultDt_s : msg.dt;
  trajectory.use_heading = msg.use_heading;
  trajectory.is_loop = msg.loop;
  trajectory.input_id = msg.input_id;
  const std::lock_guard<std::mutex> lock(*shared_.mutex);
  if (!msg.header.stamp.isZero()) {
    trajectory.skip_s = voxnav::base::to_seconds(shared_.uav->stamp_ns()) - msg.header.stamp.toSec();
    if (trajectory.skip_s < -1e-3) {
      ROS_WARN_STREAM_THROTTLE(kLogPeriod_s, "[UavSimulator]: a trajectory is from the future by "
                                                 << -trajectory.skip_s << " s, flying it now");
    }
    trajectory.skip_s = std::max(0.0, trajectory.skip_s);
  }
  const voxnav_simulation::SafetyVerdict verdict = keep_inside(config_.safety_area, &trajectory);
  if (!verdict.refusal.empty()) return {{false, verdict.refusal}};
  if (msg.fly_now) return {fly(trajectory), verdict.is_modified};
  // The trajectory is checked by flying it and is then stopped in place, because loading a trajectory ends the present
  // one.
  Result result = fly(trajectory);
  if (result.success) shared_.uav->hover();
  return {result, verdict.is_modified};
}

UavCommands::Result UavCommands::fly(const TrackedTrajectory& trajectory) {
  Result result = shared_.uav->set_trajectory(trajectory);
  if (!result.success) return result;
  loaded_ = trajectory;
  stopped_at_s_ = trajectory.skip_s;
  return result;
}

UavCommands::Result UavCommands::stop_tracking() {
  if (shared_.uav->tracker().mode() != TrackerMode::kTrajectory) return {false, "not tracking a trajectory"};
  const auto index = static_cast<double>(shared_.uav->tracker().trajectory_index());
  if (loaded_) stopped_at_s_ = index * loaded_->dt_s;
  return shared_.uav->hover();
}

UavCommands::Result UavCommands::start_tracking() {
  if (!loaded_) return {false, "no trajectory was loaded"};
  TrackedTrajectory trajectory = *loaded_;
  trajectory.skip_s = 0;
  return fly(trajectory);
}

UavCommands::Result UavCommands::resume_tracking() {
  if (!loaded_) return {false, "no trajectory was loaded"};
  TrackedTrajectory trajectory = *loaded_;
  trajectory.skip_s = stopped_at_s_;
  return fly(trajectory);
}

UavCommands::Result UavCommands::go_to_start() {
  if (!loaded_) return {false, "no trajectory was loaded"};
  return shared_.uav->go_to(loaded_->points.front());
}

}  // namespace voxnav_ros
