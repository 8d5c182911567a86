// SPDX-License-Identifier: BSD-3-Clause
#include "messages.hpp"

#include <cmath>
#include <cstdio>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros::uav_messages {
namespace {

using voxnav_simulation::ActiveController;
using voxnav_simulation::FlightPhase;
using voxnav_simulation::KinematicState;
using voxnav_simulation::TrackerMode;
using voxnav_simulation::Vec3;

constexpr double kEarthRadius_m = 6378137.0;
constexpr double kRadPerDeg = M_PI / 180.0;

geometry_msgs::Vector3 vector(const Vec3& v) {
  geometry_msgs::Vector3 out;
  out.x = v.x();
  out.y = v.y();
  out.z = v.z();
  return out;
}

void fill_prediction(Uav* uav, const std_msgs::Header& header, const UavFrames& frames,
                     mrs_msgs::MpcPredictionFullState* out) {
  out->header = header;
  out->input_id = uav->tracker().input_id();
  for (int i = 0; i < kNumPredicted; ++i) {
    const KinematicState s = transformed(frames.T_C_O(), uav->predicted(predicted_ahead_s(i)));
    out->stamps.push_back(header.stamp + ros::Duration(predicted_ahead_s(i)));
    out->position.push_back(to_msg(s.position));
    out->velocity.push_back(vector(s.velocity));
    out->acceleration.push_back(vector(s.acceleration));
    out->jerk.push_back(vector(s.jerk));
    out->heading.push_back(s.heading_rad);
    out->heading_rate.push_back(s.heading_rate);
    out->heading_acceleration.push_back(s.heading_acceleration);
    out->heading_jerk.push_back(s.heading_jerk);
  }
}

std::uint8_t tracker_state(const Uav& uav) {
  using Status = mrs_msgs::TrackerStatus;
  if (uav.phase() == FlightPhase::kIdle) return Status::STATE_IDLE;
  if (uav.phase() == FlightPhase::kTakingOff) return Status::STATE_TAKEOFF;
  if (uav.phase() == FlightPhase::kLanding && uav.controller() != ActiveController::kFailsafe)
    return Status::STATE_LAND;
  if (uav.tracker().mode() == TrackerMode::kTrajectory) return Status::STATE_TRAJECTORY;
  if (uav.tracker().mode() == TrackerMode::kGoal) return Status::STATE_REFERENCE;
  return Status::STATE_HOVER;
}

const char* tracker_name(const Uav& uav) {
  if (uav.phase() == FlightPhase::kIdle) return "NullTracker";
  // The failsafe controller needs no tracker, and leaves the active one as it is.
  if (uav.controller() == ActiveController::kFailsafe) return "MpcTracker";
  return uav.phase() == FlightPhase::kFlying && !uav.is_held() ? "MpcTracker" : "LandoffTracker";
}

const char* controller_name(const Uav& uav) {
  if (uav.phase() == FlightPhase::kIdle || uav.controller() == ActiveController::kFailsafe) return "FailsafeController";
  return uav.controller() == ActiveController::kEmergency ? "EmergencyController" : "Se3Controller";
}

}  // namespace

nav_msgs::Odometry odometry(const BodyState& state, const std_msgs::Header& header, const std::string& child) {
  nav_msgs::Odometry out;
  out.header = header;
  out.child_frame_id = child;
  out.pose.pose = to_msg(state.pose);
  out.twist.twist.linear = vector(state.pose.linear().transpose() * state.velocity);
  out.twist.twist.angular = vector(state.angular_velocity);
  return out;
}

mrs_msgs::UavState uav_state(const Uav& uav, const std_msgs::Header& header, const UavFrames& frames) {
  const BodyState state = transformed(frames.T_C_O(), uav.estimate());
  mrs_msgs::UavState out;
  out.header = header;
  out.child_frame_id = frames.body();
  out.estimator_horizontal = out.estimator_vertical = out.estimator_heading = frames.estimator();
  out.estimator_iteration = uav.estimator_iteration() + frames.num_switches();
  out.pose = to_msg(state.pose);
  out.velocity.linear = vector(state.velocity);
  out.velocity.angular = vector(state.angular_velocity);
  out.acceleration.linear = vector(state.acceleration);
  return out;
}

mrs_msgs::TrackerCommand tracker_command(Uav* uav, const std_msgs::Header& header, const UavFrames& frames) {
  mrs_msgs::TrackerCommand out;
  const KinematicState s = transformed(frames.T_C_O(), uav->tracker().state());
  out.header = header;
  out.position = to_msg(s.position);
  out.velocity = vector(s.velocity);
  out.acceleration = vector(s.acceleration);
  out.jerk = vector(s.jerk);
  out.heading = s.heading_rad;
  out.heading_rate = s.heading_rate;
  out.heading_acceleration = s.heading_acceleration;
  out.heading_jerk = s.heading_jerk;
  out.orientation.w = 1.0;
  for (auto* use :
       {&out.use_position_horizontal, &out.use_position_vertical, &out.use_velocity_horizontal,
        &out.use_velocity_vertical, &out.use_acceleration, &out.use_jerk, &out.use_heading, &out.use_heading_rate,
        &out.use_heading_acceleration, &out.use_heading_jerk, &out.use_full_state_prediction}) {
    *use = 1;
  }
  fill_prediction(uav, header, frames, &out.full_state_prediction);
  return out;
}

/// As in MRS, the number in the name is the priority, and single precision rounds the places.
mrs_msgs::FutureTrajectory future_trajectory(Uav* uav, const ros::Time& stamp, const UavSimulatorConfig& config) {
  mrs_msgs::FutureTrajectory out;
  out.stamp = stamp;
  out.uav_name = config.uav_name;
  int number = 0;
  if (std::sscanf(config.uav_name.c_str(), "uav%d", &number) == 1) out.priority = number;
  for (int i = 0; i < kNumPredicted; ++i) {
    const Vec3 place = uav->predicted(predicted_ahead_s(i)).position;
    mrs_msgs::FuturePoint point;
    point.x = static_cast<float>(place.x() + config.utm_east_m);
    point.y = static_cast<float>(place.y() + config.utm_north_m);
    point.z = static_cast<float>(place.z());
    out.points.push_back(point);
  }
  return out;
}

mrs_msgs::DynamicsConstraints constraints(const TrackerLimits& l) {
  mrs_msgs::DynamicsConstraints out;
  out.horizontal_speed = l.horizontal.speed;
  out.horizontal_acceleration = l.horizontal.acceleration;
  out.horizontal_jerk = out.horizontal_snap = l.horizontal.jerk;
  out.vertical_ascending_speed = l.ascending.speed;
  out.vertical_ascending_acceleration = l.ascending.acceleration;
  out.vertical_ascending_jerk = out.vertical_ascending_snap = l.ascending.jerk;
  out.vertical_descending_speed = l.descending.speed;
  out.vertical_descending_acceleration = l.descending.acceleration;
  out.vertical_descending_jerk = out.vertical_descending_snap = l.descending.jerk;
  out.heading_speed = l.heading.speed;
  out.heading_acceleration = l.heading.acceleration;
  out.heading_jerk = out.heading_snap = l.heading.jerk;
  out.roll_rate = out.pitch_rate = 60.0 * kRadPerDeg;
  out.yaw_rate = 10.0 * kRadPerDeg;
  out.tilt = 60.0 * kRadPerDeg;
  return out;
}

mrs_msgs::ControlManagerDiagnostics control_diagnostics(const Uav& uav, const std_msgs::Header& header,
                                                        const std::string& uav_name, const UavFrames& frames) {
  mrs_msgs::ControlManagerDiagnostics out;
  out.stamp = header.stamp;
  out.uav_name = uav_name;
  out.output_enabled = uav.phase() != FlightPhase::kIdle;
  out.flying_normally = uav.is_flying_normally();
  out.bumper_active = uav.is_repelled();
  out.joystick_active = uav.is_remote();
  out.desired_uav_state_rate = 100;
  out.active_tracker = tracker_name(uav);
  out.active_controller = controller_name(uav);
  out.available_trackers = {"MpcTracker", "LandoffTracker", "NullTracker"};
  out.human_switchable_trackers = {1, 0, 0};
  out.available_controllers = {"Se3Controller", "EmergencyController", "FailsafeController"};
  out.human_switchable_controllers = {1, 0, 0};
  out.controller_status.active = out.output_enabled;
  mrs_msgs::TrackerStatus& status = out.tracker_status;
  status.active = out.output_enabled;
  // As the MRS trackers do: whoever watches this sees that somebody let the vehicle hover.
  status.callbacks_enabled = out.flying_normally && uav.tracker().mode() != TrackerMode::kBrake;
  status.state = tracker_state(uav);
  status.have_goal = uav.phase() == FlightPhase::kFlying && uav.tracker().has_goal();
  status.tracking_trajectory = uav.phase() == FlightPhase::kFlying && uav.tracker().mode() == TrackerMode::kTrajectory;
  status.trajectory_length = static_cast<std::int32_t>(uav.tracker().trajectory_size());
  status.trajectory_idx = static_cast<std::int32_t>(uav.tracker().trajectory_index());
  status.trajectory_reference.header = header;
  const voxnav_simulation::HeadedPoint goal = transformed(frames.T_C_O(), uav.tracker().goal());
  status.trajectory_reference.reference.position = to_msg(goal.position);
  status.trajectory_reference.reference.heading = goal.heading_rad;
  return out;
}

mrs_msgs::ConstraintManagerDiagnostics constraint_diagnostics(const TrackerLimits& limits, ConstraintSet set,
                                                              const ros::Time& stamp) {
  mrs_msgs::ConstraintManagerDiagnostics out;
  out.stamp = stamp;
  out.loaded = out.available = voxnav::base::all_words<ConstraintSet>();
  out.current_name = voxnav::base::word_of(set);
  out.current_values = constraints(limits);
  return out;
}

mrs_msgs::EstimationDiagnostics estimation_diagnostics(const Uav& uav, const std_msgs::Header& header,
                                                       const UavFrames& frames, const UavSimulatorConfig& config) {
  mrs_msgs::EstimationDiagnostics out;
  const auto state = uav_state(uav, header, frames);
  out.header = header;
  out.child_frame_id = frames.body();
  out.pose = state.pose;
  out.velocity = state.velocity;
  out.acceleration = state.acceleration;
  out.agl_height = uav.height_m().value_or(std::nan(""));
  out.max_flight_z = 1000.0;
  out.sm_state = uav.phase() == FlightPhase::kIdle ? "READY_FOR_FLIGHT_STATE" : "FLYING_STATE";
  out.current_state_estimator = out.estimator_horizontal = out.estimator_vertical = out.estimator_heading =
      frames.estimator();
  out.estimator_agl_height = "garmin_agl";
  out.estimator_iteration = state.estimator_iteration;
  out.estimation_rate = static_cast<std::uint32_t>(config.state_hz);
  out.running_state_estimators = out.switchable_state_estimators = frames.estimators();
  return out;
}

mrs_msgs::UavManagerDiagnostics manager_diagnostics(const Uav& uav, const ros::Time& stamp, double flight_time_s,
                                                    const UavSimulatorConfig& config) {
  mrs_msgs::UavManagerDiagnostics out;
  out.stamp = stamp;
  out.uav_name = config.uav_name;
  std_msgs::Header header;
  const auto here = gnss(uav.estimate().pose.translation(), header, config);
  out.home_latitude = config.origin_latitude_deg;
  out.home_longitude = config.origin_longitude_deg;
  out.cur_latitude = here.latitude;
  out.cur_longitude = here.longitude;
  out.flight_time = flight_time_s;
  switch (uav.phase()) {
    case FlightPhase::kIdle:
      out.state = mrs_msgs::UavManagerDiagnostics::STATE_IDLING;
      break;
    case FlightPhase::kTakingOff:
      out.state = mrs_msgs::UavManagerDiagnostics::STATE_TAKING_OFF;
      break;
    case FlightPhase::kFlying:
      out.state = mrs_msgs::UavManagerDiagnostics::STATE_FLYING;
      break;
    case FlightPhase::kLanding:
      out.state = mrs_msgs::UavManagerDiagnostics::STATE_LANDING;
      break;
  }
  return out;
}

sensor_msgs::Imu imu(const voxnav_simulation::ImuReading& sample, const std::string& frame_id) {
  sensor_msgs::Imu out;
  out.header.stamp = to_ros(sample.stamp_ns);
  out.header.frame_id = frame_id;
  out.angular_velocity = vector(sample.gyro);
  out.linear_acceleration = vector(sample.accel);
  out.orientation.w = 1.0;
  out.orientation_covariance[0] = -1.0;  // which says by convention that there is no orientation
  return out;
}

sensor_msgs::NavSatFix gnss(const Vec3& position, const std_msgs::Header& header, const UavSimulatorConfig& config) {
  sensor_msgs::NavSatFix out;
  out.header = header;
  out.latitude = config.origin_latitude_deg + position.y() / kEarthRadius_m / kRadPerDeg;
  const double radius = kEarthRadius_m * std::cos(config.origin_latitude_deg * kRadPerDeg);
  out.longitude = config.origin_longitude_deg + position.x() / radius / kRadPerDeg;
  out.altitude = position.z();
  out.status.status = sensor_msgs::NavSatStatus::STATUS_FIX;
  out.status.service = sensor_msgs::NavSatStatus::SERVICE_GPS;
  out.position_covariance_type = sensor_msgs::NavSatFix::COVARIANCE_TYPE_APPROXIMATED;
  out.position_covariance[0] = out.position_covariance[4] = out.position_covariance[8] = 1.0;
  return out;
}

Vec3 place_of(double latitude_deg, double longitude_deg, const UavSimulatorConfig& config) {
  const double radius = kEarthRadius_m * std::cos(config.origin_latitude_deg * kRadPerDeg);
  return {(longitude_deg - config.origin_longitude_deg) * kRadPerDeg * radius,
          (latitude_deg - config.origin_latitude_deg) * kRadPerDeg * kEarthRadius_m, 0.0};
}

mrs_msgs::RtkGps rtk(const Vec3& position, const std_msgs::Header& header, const UavSimulatorConfig& config) {
  const auto fix = gnss(position, header, config);
  mrs_msgs::RtkGps out;
  out.header = header;
  out.gps.latitude = fix.latitude;
  out.gps.longitude = fix.longitude;
  out.gps.altitude = fix.altitude;
  out.gps.covariance[0] = out.gps.covariance[4] = out.gps.covariance[8] = 1e-4;
  out.status = fix.status;
  out.fix_type.fix_type = mrs_msgs::RtkFixType::RTK_FIX;
  return out;
}

sensor_msgs::Range range(const std::optional<double>& range_m, const std_msgs::Header& header, double max_m) {
  sensor_msgs::Range out;
  out.header = header;
  out.radiation_type = sensor_msgs::Range::INFRARED;
  out.field_of_view = 0.01F;
  out.min_range = 0.05F;
  out.max_range = static_cast<float>(max_m);
  // REP 117 has infinity for "nothing within range".
  out.range = range_m ? static_cast<float>(*range_m) : std::numeric_limits<float>::infinity();
  return out;
}

}  // namespace voxnav_ros::uav_messages
