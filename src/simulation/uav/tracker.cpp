// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/tracker.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "voxnav_simulation/limited_motion.hpp"

namespace voxnav_simulation {
namespace {

using voxnav::geometry::wrap_angle;

struct FullReference {
  MotionReference<2> horizontal;
  MotionReference<1> vertical;
  MotionReference<1> heading;
};

FullReference reference_at(const HeadedPoint& goal) {
  FullReference out;
  out.horizontal.position = goal.position.head<2>();
  out.vertical.position[0] = goal.position.z();
  out.heading.position[0] = goal.heading_rad;
  return out;
}

FullReference reference_of(const Spline::Value& value) {
  FullReference out;
  out.horizontal = {value.position.head<2>(), value.velocity.head<2>(), value.acceleration.head<2>(),
                    value.jerk.head<2>(), true};
  const auto one = [](double x) { return Eigen::Matrix<double, 1, 1>(x); };
  out.vertical = {one(value.position[2]), one(value.velocity[2]), one(value.acceleration[2]), one(value.jerk[2]), true};
  out.heading = {one(value.position[3]), one(value.velocity[3]), one(value.acceleration[3]), one(value.jerk[3]), true};
  return out;
}

FullReference moved(FullReference reference, const Vec3& offset) {
  reference.horizontal.position += offset.head<2>();
  reference.vertical.position[0] += offset.z();
  return reference;
}

/// Raises a reference to a least height. A reference without height, which brakes, is raised if the vehicle is lower.
void raise(double floor_m, double z_m, FullReference* reference) {
  MotionReference<1>& vertical = reference->vertical;
  if ((vertical.has_position ? vertical.position[0] : z_m) >= floor_m) return;
  vertical = MotionReference<1>{};
  vertical.position[0] = floor_m;
}

MotionLimits motion_limits(const TrackerAxisLimits& limits) { return {limits.speed, limits.acceleration, limits.jerk}; }

/// Returns the limits of the vertical motion. The limits of speed may differ upwards and downwards, so the direction of
/// the reference decides; acceleration and jerk have the same limit both ways.
MotionLimits vertical_limits(const TrackerLimits& limits, const MotionReference<1>& reference, double z) {
  const bool is_up = reference.has_position ? reference.position[0] > z : false;
  return {is_up ? limits.ascending.speed : limits.descending.speed, limits.vertical_acceleration(),
          limits.vertical_jerk()};
}

MotionState<1> axis_state(double p, double v, double a) {
  MotionState<1> out;
  out.position[0] = p;
  out.velocity[0] = v;
  out.acceleration[0] = a;
  return out;
}

KinematicState advance(const KinematicState& s, const FullReference& reference, const TrackerLimits& limits) {
  MotionState<2> h;
  h.position = s.position.head<2>();
  h.velocity = s.velocity.head<2>();
  h.acceleration = s.acceleration.head<2>();
  h = limited_step<2>(h, reference.horizontal, motion_limits(limits.horizontal), kStep_s);
  const MotionLimits z_limits = vertical_limits(limits, reference.vertical, s.position.z());
  const auto z = limited_step<1>(axis_state(s.position.z(), s.velocity.z(), s.acceleration.z()), reference.vertical,
                                 z_limits, kStep_s);
  MotionReference<1> heading = reference.heading;
  heading.position[0] = s.heading_rad + wrap_angle(heading.position[0] - s.heading_rad);
  const auto y = limited_step<1>(axis_state(s.heading_rad, s.heading_rate, s.heading_acceleration), heading,
                                 motion_limits(limits.heading), kStep_s);
  KinematicState out;
  out.position << h.position, z.position;
  out.velocity << h.velocity, z.velocity;
  out.acceleration << h.acceleration, z.acceleration;
  out.jerk << h.jerk, z.jerk;
  out.heading_rad = wrap_angle(y.position[0]);
  out.heading_rate = y.velocity[0];
  out.heading_acceleration = y.acceleration[0];
  out.heading_jerk = y.jerk[0];
  return out;
}

bool is_at_rest(const KinematicState& s) {
  return s.velocity.norm() < 0.02 && s.acceleration.norm() < 0.1 && std::abs(s.heading_rate) < 0.02;
}

}  // namespace

Tracker::Tracker(const TrackerLimits& limits) : limits_(limits) {}

void Tracker::set_limits(const TrackerLimits& limits) {
  limits_ = limits;
  ahead_.clear();
}

void Tracker::reset(const KinematicState& state) {
  now_ = {state, TrackerMode::kHold, {state.position, state.heading_rad}, 0};
  trajectory_.reset();
  ahead_.clear();
}

void Tracker::go_to(const HeadedPoint& goal) {
  now_.mode = TrackerMode::kGoal;
  now_.goal = goal;
  trajectory_.reset();
  ahead_.clear();
}

void Tracker::brake() {
  now_.mode = TrackerMode::kBrake;
  trajectory_.reset();
  ahead_.clear();
}

void Tracker::follow(const TrackedTrajectory& trajectory) {
  if (trajectory.points.empty() || !(trajectory.dt_s > 0))
    throw std::invalid_argument("trajectory: empty or dt_s <= 0");
  std::vector<Spline::Point> points;
  double heading = now_.state.heading_rad;
  for (const HeadedPoint& point : trajectory.points) {
    if (trajectory.use_heading) heading += wrap_angle(point.heading_rad - heading);
    points.emplace_back(point.position.x(), point.position.y(), point.position.z(), heading);
  }
  now_.mode = TrackerMode::kTrajectory;
  now_.goal = trajectory.points.back();
  now_.goal.heading_rad = wrap_angle(points.back()[3]);
  now_.time_s = trajectory.skip_s;
  input_id_ = trajectory.input_id;
  trajectory_ = std::make_shared<Followed>(
      Followed{Spline(std::move(points), trajectory.dt_s), trajectory.use_heading, trajectory.is_loop});
  ahead_.clear();
}

void Tracker::set_floor(std::optional<double> floor_m, double speed_ratio) {
  if (floor_m == floor_m_) return;
  floor_m_ = floor_m;
  speed_ratio_ = floor_m ? speed_ratio : 1.0;
  ahead_.clear();
}

void Tracker::shift(const Vec3& jump) {
  now_.state.position += jump;
  now_.goal.position += jump;
  if (floor_m_) *floor_m_ += jump.z();
  if (trajectory_) {
    Followed moved = *trajectory_;
    moved.offset += jump;
    trajectory_ = std::make_shared<Followed>(std::move(moved));
  }
  ahead_.clear();
}

Tracker::Motion Tracker::next(const Motion& motion) const {
  Motion out = motion;
  FullReference reference;
  if (motion.mode == TrackerMode::kTrajectory) {
    out.time_s += kStep_s;
    if (trajectory_->is_loop && out.time_s > trajectory_->spline.duration_s())
      out.time_s -= trajectory_->spline.duration_s();
    // The reference is taken at this instant rather than one step ahead, so that a state on the trajectory stays on it.
    reference = moved(reference_of(trajectory_->spline.at(motion.time_s)), trajectory_->offset);
  } else {
    reference = reference_at(motion.goal);
    if (motion.mode == TrackerMode::kBrake) {
      reference.horizontal.has_position = reference.vertical.has_position = reference.heading.has_position = false;
    }
  }
  TrackerLimits limits = limits_;
  if (floor_m_) {
    raise(*floor_m_, motion.state.position.z(), &reference);
    limits.horizontal.speed *= speed_ratio_;
  }
  out.state = advance(motion.state, reference, limits);
  update_mode(&out);
  return out;
}

void Tracker::update_mode(Motion* motion) const {
  const KinematicState& s = motion->state;
  if (motion->mode == TrackerMode::kTrajectory && motion->time_s >= trajectory_->spline.duration_s() &&
      !trajectory_->is_loop) {
    motion->mode = TrackerMode::kGoal;
  }
  if (motion->mode == TrackerMode::kBrake && is_at_rest(s)) {
    motion->mode = TrackerMode::kHold;
    motion->goal = {s.position, s.heading_rad};
  }
  const bool is_there = (s.position - motion->goal.position).norm() < 0.05 &&
                        std::abs(wrap_angle(s.heading_rad - motion->goal.heading_rad)) < 0.05;
  if (motion->mode == TrackerMode::kGoal && is_at_rest(s) && is_there) motion->mode = TrackerMode::kHold;
}

void Tracker::step() {
  if (ahead_.empty()) {
    now_ = next(now_);
    return;
  }
  now_ = ahead_.front();
  ahead_.pop_front();
}

const KinematicState& Tracker::predicted(std::size_t num_steps) {
  if (num_steps == 0) return now_.state;
  if (num_steps > kMaxSteps) throw std::invalid_argument("prediction: too far ahead");
  while (ahead_.size() < num_steps) ahead_.push_back(next(ahead_.empty() ? now_ : ahead_.back()));
  return ahead_[num_steps - 1].state;
}

HeadedPoint Tracker::goal() const { return now_.goal; }

std::size_t Tracker::trajectory_index() const {
  return mode() == TrackerMode::kTrajectory ? trajectory_->spline.index_at(now_.time_s) : 0;
}

}  // namespace voxnav_simulation
