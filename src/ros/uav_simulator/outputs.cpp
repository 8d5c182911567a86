// SPDX-License-Identifier: BSD-3-Clause
#include "outputs.hpp"

#include <rosgraph_msgs/Clock.h>

#include <algorithm>
#include <cmath>

#include "messages.hpp"
#include "voxnav/Clearance.h"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

using voxnav_simulation::ConstraintSet;
using voxnav_simulation::FlightPhase;
using voxnav_simulation::Uav;

constexpr double kSensors_hz = 10;
constexpr double kRange_hz = 20;
constexpr double kClearance_hz = 20;
constexpr double kSlow_hz = 1;
constexpr double kFuture_hz = 2;  // predicted_trajectory_publish_rate of the MpcTracker
constexpr double kRangefinderMax_m = 40;

}  // namespace

UavOutputs::UavOutputs(ros::NodeHandle& nh, ros::NodeHandle& private_nh, const Config& config, const UavFrames& frames,
                       std::shared_ptr<const voxnav_simulation::Scene> scene)
    : config_(config.node),
      losses_(config.losses),
      frames_(frames),
      scene_(std::move(scene)),
      uav_state_(nh.advertise<mrs_msgs::UavState>("estimation_manager/uav_state", 10)),
      odom_main_(nh.advertise<nav_msgs::Odometry>("estimation_manager/odom_main", 100)),
      ground_truth_(private_nh.advertise<nav_msgs::Odometry>("ground_truth_out", 100)),
      imu_(nh.advertise<sensor_msgs::Imu>("hw_api/imu", 100)),
      rtk_(nh.advertise<mrs_msgs::RtkGps>("hw_api/rtk", 10)),
      gnss_(nh.advertise<sensor_msgs::NavSatFix>("hw_api/gnss", 10)),
      range_(nh.advertise<sensor_msgs::Range>("hw_api/distance_sensor", 10)),
      tracker_cmd_(nh.advertise<mrs_msgs::TrackerCommand>("control_manager/tracker_cmd", 10)),
      future_(nh.advertise<mrs_msgs::FutureTrajectory>("control_manager/mpc_tracker/predicted_trajectory", 2)),
      constraints_(nh.advertise<mrs_msgs::DynamicsConstraints>("control_manager/current_constraints", 10, true)),
      control_diagnostics_(nh.advertise<mrs_msgs::ControlManagerDiagnostics>("control_manager/diagnostics", 10, true)),
      constraint_diagnostics_(
          nh.advertise<mrs_msgs::ConstraintManagerDiagnostics>("constraint_manager/diagnostics", 10, true)),
      estimation_diagnostics_(
          nh.advertise<mrs_msgs::EstimationDiagnostics>("estimation_manager/diagnostics", 10, true)),
      manager_diagnostics_(nh.advertise<mrs_msgs::UavManagerDiagnostics>("uav_manager/diagnostics", 10, true)),
      clearance_(private_nh.advertise<msg::Clearance>("clearance_out", 50)) {
  if (!config_.follows_clock) clock_ = nh.advertise<rosgraph_msgs::Clock>("/clock", 10, true);
}

template <class M>
void UavOutputs::later(const ros::Publisher& publisher, const M& message) {
  queue_.push_back([&publisher, message] { publisher.publish(message); });
}

/// Where time stands still, all nodes take their inputs up to that instant, and nothing of these may be missing.
bool UavOutputs::is_lost(Kind kind) const {
  if (!losses_.is_enabled) return false;
  const voxnav::base::StampNs period_ns = voxnav::base::from_seconds(config_.lockstep_period_s);
  if (period_ns > 0 && stamp_ns_ % period_ns == 0) return false;
  const bool is_odometry = kind < Kind::kControl;
  return voxnav_simulation::is_lost(is_odometry ? losses_.odometry_ratio : losses_.diagnostics_ratio,
                                    static_cast<std::uint64_t>(config_.seed), static_cast<std::uint64_t>(kind),
                                    stamp_ns_);
}

std_msgs::Header UavOutputs::header(const std::string& frame_id) const {
  std_msgs::Header out;
  out.stamp = to_ros(stamp_ns_);
  out.frame_id = frame_id;
  return out;
}

bool UavOutputs::is_due(double hz) const {
  return step_ % std::max<std::int64_t>(1, std::llround(1.0 / (hz * voxnav_simulation::kStep_s))) == 0;
}

void UavOutputs::collect(Uav* uav, ConstraintSet constraints) {
  stamp_ns_ = uav->stamp_ns();
  step_ = (stamp_ns_ - voxnav::base::from_seconds(config_.start_time_s)) / voxnav_simulation::kStep_ns;
  note_phase(*uav);
  if (is_due(config_.state_hz)) collect_state(*uav);
  if (is_due(config_.tracker_cmd_hz)) {
    later_unless_lost(Kind::kTrackerCommand, tracker_cmd_,
                      uav_messages::tracker_command(uav, header(frames_.control()), frames_));
  }
  // The MpcTracker publishes while it is active, which it is neither on the ground nor during take-off and landing.
  if (is_due(kFuture_hz) && uav->phase() == FlightPhase::kFlying) {
    later(future_, uav_messages::future_trajectory(uav, to_ros(stamp_ns_), config_));
  }
  collect_sensors(uav);
  collect_diagnostics(*uav, constraints);
  if (scene_ && is_due(kClearance_hz)) watch_clearance(*uav);
}

void UavOutputs::collect_state(const Uav& uav) {
  const auto in_control = header(frames_.control());
  later_unless_lost(Kind::kUavState, uav_state_, uav_messages::uav_state(uav, in_control, frames_));
  later_unless_lost(Kind::kOdometry, odom_main_,
                    uav_messages::odometry(transformed(frames_.T_C_O(), uav.estimate()), in_control, frames_.body()));
  later(ground_truth_, uav_messages::odometry(uav.truth(), header(frames_.ground_truth()), frames_.body()));
  const auto tree = frames_.tree(uav, in_control.stamp);
  if (!is_lost(Kind::kTf)) queue_.emplace_back([this, tree] { tf_.sendTransform(tree); });
}

void UavOutputs::add_imu(const voxnav_simulation::ImuReading& sample) {
  later(imu_, uav_messages::imu(sample, frames_.body()));
}

void UavOutputs::collect_sensors(Uav* uav) {
  if (is_due(kRange_hz)) {
    later(range_, uav_messages::range(uav->rangefinder(), header(frames_.body()), kRangefinderMax_m));
  }
  if (!is_due(kSensors_hz)) return;
  later(rtk_, uav_messages::rtk(uav->truth().pose.translation(), header(frames_.body()), config_));
  later(gnss_, uav_messages::gnss(uav->estimate().pose.translation(), header(frames_.body()), config_));
}

void UavOutputs::collect_diagnostics(const Uav& uav, ConstraintSet constraints) {
  const auto in_control = header(frames_.control());
  if (is_due(kSensors_hz)) {
    later_unless_lost(Kind::kConstraints, constraints_, uav_messages::constraints(uav.tracker().limits()));
    later_unless_lost(Kind::kControl, control_diagnostics_,
                      uav_messages::control_diagnostics(uav, in_control, config_.uav_name, frames_));
    later_unless_lost(Kind::kEstimation, estimation_diagnostics_,
                      uav_messages::estimation_diagnostics(uav, in_control, frames_, config_));
  }
  if (!is_due(kSlow_hz)) return;
  later(constraint_diagnostics_,
        uav_messages::constraint_diagnostics(uav.tracker().limits(), constraints, in_control.stamp));
  later(manager_diagnostics_, uav_messages::manager_diagnostics(uav, in_control.stamp, flight_s_, config_));
}

void UavOutputs::note_phase(const Uav& uav) {
  const double now_s = voxnav::base::to_seconds(stamp_ns_);
  const bool is_idle = uav.phase() == FlightPhase::kIdle;
  if (was_idle_ && !is_idle) {
    take_off_s_ = now_s;
    min_clearance_m_ = config_.clearance_max_m;
    has_collided_ = false;
  }
  if (!is_idle) flight_s_ = now_s - take_off_s_;
  was_idle_ = is_idle;
}

/// The ground counts as an obstacle as well, but not during take-off and landing, when the vehicle has to be near it.
void UavOutputs::watch_clearance(const Uav& uav) {
  msg::Clearance out;
  out.header = header(frames_.ground_truth());
  out.clearance_m = scene_->clearance(uav.truth().pose.translation(), config_.clearance_max_m, stamp_ns_);
  if (uav.phase() == FlightPhase::kFlying) {
    min_clearance_m_ = std::min(min_clearance_m_, out.clearance_m);
    if (out.clearance_m < config_.vehicle_radius_m && !has_collided_) {
      has_collided_ = true;
      ROS_ERROR_STREAM("[UavSimulator]: collision: a surface is " << out.clearance_m << " m from the vehicle's centre");
    }
  }
  out.min_clearance_m = min_clearance_m_;
  out.has_collided = has_collided_;
  later(clearance_, out);
}

void UavOutputs::publish_clock(voxnav::base::StampNs stamp_ns) {
  if (config_.follows_clock) return;
  rosgraph_msgs::Clock clock;
  clock.clock = to_ros(stamp_ns);
  clock_.publish(clock);
}

void UavOutputs::publish() {
  publish_clock(stamp_ns_);
  for (const auto& send : queue_) send();
  queue_.clear();
}

}  // namespace voxnav_ros
