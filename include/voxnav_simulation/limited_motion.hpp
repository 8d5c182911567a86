// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <cmath>

namespace voxnav_simulation {

/// A point that moves with limited speed, acceleration and jerk; N = 2 for x-y, N = 1 for height and heading.
template <int N>
struct MotionState {
  using Vector = Eigen::Matrix<double, N, 1>;
  Vector position = Vector::Zero();
  Vector velocity = Vector::Zero();
  Vector acceleration = Vector::Zero();
  Vector jerk = Vector::Zero();
};

/// The position that the point should have, and the motion it should have there.
template <int N>
struct MotionReference {
  using Vector = Eigen::Matrix<double, N, 1>;
  Vector position = Vector::Zero();
  Vector velocity = Vector::Zero();
  Vector acceleration = Vector::Zero();
  Vector jerk = Vector::Zero();
  bool has_position = true;  ///< false: only the velocity counts, as for braking
};

struct MotionLimits {
  double speed;
  double acceleration;
  double jerk;
};

namespace detail {

template <class Vector>
Vector clip_norm(const Vector& v, double limit) {
  const double norm = v.norm();
  if (norm <= limit) return v;
  return v * (limit / norm);
}

/// Limits the forward acceleration near the speed limit, so that the speed settles at the limit without overshoot.
template <class Vector>
void keep_speed(const Vector& velocity, double limit, double gain, Vector* acceleration) {
  const double speed = velocity.norm();
  if (speed < 1e-6) return;
  const Vector forward = velocity / speed;
  const double excess = forward.dot(*acceleration) - gain * (limit - speed);
  if (excess > 0) *acceleration -= forward * excess;
}

/// The speed at which a distance is closed: proportional to the distance near the goal, and farther away the speed from
/// which the deceleration `braking` still stops in time.
struct ApproachSpeed {
  ApproachSpeed(double distance, double braking, double gain) {
    const double linear_m = braking / (gain * gain);
    if (distance <= linear_m) {
      speed = gain * distance;
      slope = gain;
    } else {
      speed = std::sqrt(2.0 * braking * (distance - 0.5 * linear_m));
      slope = braking / speed;
    }
  }
  double speed;
  double slope;
};

}  // namespace detail

/// Makes one step towards the reference with cascaded control loops that saturate: the position error gives a velocity
/// (by a square-root approach law), the velocity error an acceleration, and the acceleration error a jerk. Each is
/// clipped to its limit, so that any reference gives a motion within limits, even one that no vehicle could fly. The
/// speed may exceed its limit only while it is being reduced.
template <int N>
MotionState<N> limited_step(const MotionState<N>& s, const MotionReference<N>& reference, const MotionLimits& limits,
                            double dt_s) {
  using Vector = Eigen::Matrix<double, N, 1>;
  // The velocity loop must not ask for more jerk than there is, and the acceleration loop must be four times as fast
  // (critical damping), else speed overshoots its limit.
  const double velocity_gain = std::min(2.5, 0.4 * limits.jerk / limits.acceleration);
  const double acceleration_gain = 4.0 * velocity_gain;
  const double position_gain = 0.4 * velocity_gain;

  Vector velocity = reference.velocity;
  // The motion of the reference itself is fed forward as far as a vehicle could follow it.
  const bool is_feasible = reference.velocity.norm() <= 1.05 * limits.speed &&
                           reference.acceleration.norm() <= 1.05 * limits.acceleration &&
                           reference.jerk.norm() <= limits.jerk;
  Vector acceleration = is_feasible ? reference.acceleration : Vector(Vector::Zero());
  if (reference.has_position) {
    const Vector error = reference.position - s.position;
    const double distance = error.norm();
    if (distance > 1e-9) {
      const detail::ApproachSpeed approach(distance, 0.7 * limits.acceleration, position_gain);
      const Vector direction = error / distance;
      const Vector closing = reference.velocity - s.velocity;
      const double radial = direction.dot(closing);
      velocity += direction * approach.speed;
      // The wanted velocity changes along the braking curve; feeding that change forward avoids a lag behind it.
      const Vector change =
          direction * (approach.slope * radial) + (closing - direction * radial) * (approach.speed / distance);
      if (velocity.norm() < limits.speed) acceleration += change;
    }
  }
  velocity = detail::clip_norm<Vector>(velocity, limits.speed);
  acceleration += (velocity - s.velocity) * velocity_gain;
  detail::keep_speed<Vector>(s.velocity, limits.speed, velocity_gain, &acceleration);
  acceleration = detail::clip_norm<Vector>(acceleration, limits.acceleration);
  Vector jerk = (acceleration - s.acceleration) * acceleration_gain;
  if (is_feasible) jerk += reference.jerk;
  jerk = detail::clip_norm<Vector>(jerk, limits.jerk);

  MotionState<N> out;
  out.acceleration = s.acceleration + jerk * dt_s;
  // The ball of allowed accelerations is convex, so that only rounding, or limits that were just lowered, are cut here.
  const double allowed = std::max(limits.acceleration, s.acceleration.norm());
  out.acceleration = detail::clip_norm<Vector>(out.acceleration, allowed);
  out.jerk = (out.acceleration - s.acceleration) / dt_s;
  out.velocity = s.velocity + 0.5 * (s.acceleration + out.acceleration) * dt_s;
  out.position = s.position + s.velocity * dt_s + (2.0 * s.acceleration + out.acceleration) * (dt_s * dt_s / 6.0);
  return out;
}

}  // namespace voxnav_simulation
