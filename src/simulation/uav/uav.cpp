// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/uav.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {
namespace {

Vec3 rotation_vector(const Eigen::Matrix3d& R) {
  const Eigen::AngleAxisd angle_axis(R);
  return angle_axis.angle() * angle_axis.axis();
}

CommandResult refused(const std::string& why) { return {false, why}; }

/// Puts flat, bare ground where the vehicle senses nothing else.
SensedWorld completed(SensedWorld s) {
  if (!s.ground_height) s.ground_height = [](double, double) { return std::optional<double>(0.0); };
  if (!s.clearance) s.clearance = [](const Vec3&, double max_m, voxnav::base::StampNs) { return max_m; };
  if (!s.range) {
    s.range = [](const Vec3&, const Vec3&, double, voxnav::base::StampNs) { return std::optional<double>(); };
  }
  return s;
}

}  // namespace

Eigen::Matrix3d attitude_of(const Vec3& acceleration, double heading_rad) {
  const Vec3 z = (acceleration + Vec3(0, 0, kGravity)).normalized();
  const double c = std::cos(heading_rad), s = std::sin(heading_rad);
  const Vec3 x = Vec3(c, s, -(z.x() * c + z.y() * s) / z.z()).normalized();
  Eigen::Matrix3d R;
  R << x, z.cross(x), z;
  return R;
}

Uav::Uav(const UavSetup& setup, std::uint64_t seed, SensedWorld sensed_world)
    : config_(voxnav::base::checked(setup.uav)),
      avoidance_(setup.faults.avoidance),
      sensed_world_(completed(std::move(sensed_world))),
      drift_(setup.drift, seed),
      imu_model_(setup.imu, seed),
      random_(seed, 0x72616e676500),
      tracker_(setup.limits),
      response_(setup.faults.tracking, !setup.faults.tracking.is_enabled),
      wind_(setup.faults.wind, seed),
      noise_(setup.faults.state_noise, seed),
      climb_(setup.faults.avoidance, seed),
      bumper_(setup.faults.bumper),
      resets_(setup.faults.resets, seed),
      standing_heading_rad_(config_.start_heading_rad),
      refusals_(setup.faults.refusals),
      is_free_(setup.faults.tracking.is_enabled || setup.faults.wind.is_enabled) {
  const double ground_m = sensed_world_.ground_height(config_.start_m[0], config_.start_m[1]).value_or(0.0);
  standing_W_ = Vec3(config_.start_m[0], config_.start_m[1], ground_m + config_.standing_height_m);
  stand();
  place(0);
  imu_.accel = Vec3(0, 0, kGravity);
}

/// Makes a step of a vehicle that stands on the ground: its true pose stays the same and its estimate drifts.
void Uav::stand() {
  KinematicState state;
  state.position = standing_W_ + drift();
  state.velocity = drift_.velocity();
  state.heading_rad = voxnav::geometry::wrap_angle(standing_heading_rad_ + drift_.heading_rad());
  tracker_.reset(state);
  response_.reset(state);
}

void Uav::step() {
  const BodyState before = truth_;
  drift_.step(kStep_s);
  wind_.step(kStep_s);
  noise_.step(kStep_s);
  if (phase_ == FlightPhase::kIdle) {
    stand();
  } else {
    meet_faults();
    tracker_.step();
    if (is_free_) response_.step(tracker_.state(), wind_.velocity() + drift_.velocity(), kStep_s);
  }
  stamp_ns_ += kStep_ns;
  place(kStep_s);
  measure(before);
  update_phase();
}

/// Sets the true and the estimated state, which follow from the state of the tracker or the body, and from the drift.
void Uav::place(double dt_s) {
  const KinematicState s = tracker_.state();
  const bool is_idle = phase_ == FlightPhase::kIdle;
  const Vec3 position = is_free_ ? response_.position() : s.position;
  const Vec3 velocity = is_free_ ? response_.velocity() : s.velocity;
  const Vec3 acceleration = is_free_ ? response_.acceleration() : s.acceleration;
  const Vec3 thrust = is_free_ ? response_.thrust() : s.acceleration;
  const Eigen::Matrix3d R_before = truth_.pose.linear();
  truth_.pose.translation() = is_idle ? standing_W_ : Vec3(position - drift());
  truth_.velocity = is_idle ? Vec3(Vec3::Zero()) : Vec3(velocity - drift_.velocity());
  truth_.acceleration = is_idle ? Vec3(Vec3::Zero()) : Vec3(acceleration - drift_.acceleration());
  const Vec3 tilting = is_idle ? Vec3(Vec3::Zero()) : Vec3(thrust - drift_.acceleration());
  truth_.pose.linear() = attitude_of(tilting, s.heading_rad - drift_.heading_rad());
  truth_.angular_velocity.setZero();
  if (dt_s > 0) truth_.angular_velocity = rotation_vector(R_before.transpose() * truth_.pose.linear()) / dt_s;
  estimate_ = {Pose::Identity(), velocity + noise_.velocity(), acceleration, truth_.angular_velocity};
  estimate_.pose.translation() = position + noise_.position();
  estimate_.pose.linear() = Eigen::AngleAxisd(drift_.heading_rad(), Vec3::UnitZ()) * truth_.pose.linear();
}

void Uav::measure(const BodyState& before) {
  const Eigen::Quaterniond half =
      Eigen::Quaterniond(before.pose.linear()).slerp(0.5, Eigen::Quaterniond(truth_.pose.linear()));
  const Vec3 acceleration = (truth_.velocity - before.velocity) / kStep_s;
  imu_.stamp_ns = stamp_ns_;
  imu_.gyro = truth_.angular_velocity;
  imu_.accel = half.conjugate() * (acceleration + Vec3(0, 0, kGravity));
  imu_model_.corrupt(kStep_s, &imu_);
}

std::optional<double> Uav::height_m() const {
  const Vec3& p = truth_.pose.translation();
  const auto ground = sensed_world_.ground_height(p.x(), p.y());
  if (!ground) return std::nullopt;
  return p.z() - *ground;
}

std::optional<double> Uav::rangefinder() {
  const auto height = height_m();
  if (!height) return std::nullopt;
  // The ground below the vehicle is assumed to be level.
  const double range = *height / truth_.pose.linear()(2, 2) + config_.rangefinder_noise_m * random_.normal();
  if (range > config_.rangefinder_max_m) return std::nullopt;
  return std::max(range, 0.0);
}

void Uav::update_phase() {
  if (phase_ == FlightPhase::kTakingOff && tracker_.mode() == TrackerMode::kHold) phase_ = FlightPhase::kFlying;
  if (phase_ != FlightPhase::kLanding) return;
  const double above_m = height_m().value_or(config_.standing_height_m) - config_.standing_height_m;
  if (above_m > 0.02 || tracker_.state().velocity.norm() > 0.1) {
    // The estimate drifts on the way down, so the height of the goal is corrected close to the ground.
    HeadedPoint goal = tracker_.goal();
    const double goal_z = tracker_.state().position.z() - above_m;
    if (above_m < 0.5 && std::abs(goal.position.z() - goal_z) > 0.005) {
      goal.position.z() = goal_z;
      tracker_.go_to(goal);
    }
    return;
  }
  is_remote_ = is_held_ = false;
  controller_ = ActiveController::kNormal;
  standing_W_ = truth_.pose.translation();
  standing_heading_rad_ = voxnav::geometry::yaw_of(truth_.pose);
  phase_ = FlightPhase::kIdle;
}

std::string Uav::refusal() const {
  switch (phase_) {
    case FlightPhase::kIdle:
      return "not flying: take off first";
    case FlightPhase::kTakingOff:
      return "callbacks are disabled during take-off";
    case FlightPhase::kLanding:
      return "callbacks are disabled during landing";
    case FlightPhase::kFlying:
      return is_held_ ? "the tracker 'LandoffTracker' does not implement this" : "";
  }
  return {};
}

/// Why goals and trajectories are refused; empty if they are taken.
std::string Uav::reference_refusal() const {
  std::string why = refusal();
  if (why.empty() && is_remote_) why = "callbacks are disabled under remote control";
  if (why.empty() && !has_callbacks_) why = "callbacks are disabled";
  if (why.empty() && is_repelled_) why = "callbacks are disabled while the bumper repels an obstacle";
  if (why.empty() && refusals_.is_enabled && tracker_.mode() == TrackerMode::kBrake) {
    why = "callbacks are disabled while braking into a hover";
  }
  return why;
}

CommandResult Uav::take_off() {
  if (phase_ != FlightPhase::kIdle) return refused("already in the air");
  phase_ = FlightPhase::kTakingOff;
  has_callbacks_ = true;  // the UAV manager enables them with every take-off
  const KinematicState s = tracker_.state();
  const Vec3 up(0, 0, config_.take_off_height_m - config_.standing_height_m);
  tracker_.go_to({s.position + up, s.heading_rad});
  return {true, "taking off"};
}

CommandResult Uav::set_remote(bool is_remote) {
  if (is_remote && !is_flying_normally()) return refused("can not activate the remote control, not flying normally");
  is_remote_ = is_remote;
  if (is_remote) tracker_.brake();
  return {true, is_remote ? "the pilot has the vehicle" : "the pilot has given the vehicle back"};
}

CommandResult Uav::hover() {
  if (const std::string why = refusal(); !why.empty()) return refused(why);
  tracker_.brake();
  return {true, "hovering"};
}

CommandResult Uav::go_to(const HeadedPoint& goal_O) {
  if (const std::string why = reference_refusal(); !why.empty()) return refused(why);
  if (!is_finite(goal_O)) return refused("the reference contains a value that is not finite");
  tracker_.go_to(goal_O);
  return {true, "reference set"};
}

CommandResult Uav::set_trajectory(const TrackedTrajectory& trajectory_O) {
  if (const std::string why = reference_refusal(); !why.empty()) return refused(why);
  if (trajectory_O.points.empty()) return refused("the trajectory is empty");
  for (const HeadedPoint& point : trajectory_O.points) {
    if (!is_finite(point)) return refused("the trajectory contains a value that is not finite");
  }
  if (!(trajectory_O.dt_s >= 0.01)) return refused("the trajectory's dt is shorter than the tracker's step of 0.01 s");
  const double duration = trajectory_O.dt_s * static_cast<double>(trajectory_O.points.size() - 1);
  if (!std::isfinite(trajectory_O.skip_s) || trajectory_O.skip_s < 0 || trajectory_O.skip_s > duration) {
    return refused("the trajectory is over already");
  }
  const HeadedPoint &first = trajectory_O.points.front(), &last = trajectory_O.points.back();
  const double turn = voxnav::geometry::wrap_angle(last.heading_rad - first.heading_rad);
  if (trajectory_O.is_loop && ((last.position - first.position).norm() > 1.0 || std::abs(turn) > 0.2)) {
    return refused("the trajectory cannot loop: its ends are more than 1 m or 0.2 rad apart");
  }
  tracker_.follow(trajectory_O);
  return {true, "trajectory set"};
}

const KinematicState& Uav::predicted(double ahead_s) {
  return tracker_.predicted(static_cast<std::size_t>(std::llround(std::clamp(ahead_s, 0.0, 10.0) / kStep_s)));
}

}  // namespace voxnav_simulation
