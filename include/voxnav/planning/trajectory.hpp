// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::planning {

/// The speed and acceleration limits of the vehicle, as in mrs_msgs/DynamicsConstraints.
struct DynamicsLimits {
  double horizontal_speed_mps = 0.0;
  double horizontal_acceleration_mps2 = 0.0;
  double ascending_speed_mps = 0.0;
  double ascending_acceleration_mps2 = 0.0;
  double descending_speed_mps = 0.0;
  double descending_acceleration_mps2 = 0.0;

  /// Returns true if all limits are positive and finite.
  bool is_valid() const;
};

/// A trajectory: positions at equal time steps, at the last of which the vehicle is at rest.
class Trajectory {
 public:
  Trajectory() = default;
  /// @throws std::invalid_argument if there are no points, one is not finite, or dt_s is not positive
  Trajectory(std::vector<geometry::Vec3> points, double dt_s);

  bool empty() const { return points_.empty(); }
  const std::vector<geometry::Vec3>& points() const { return points_; }
  double dt_s() const { return dt_s_; }
  double duration_s() const { return points_.empty() ? 0.0 : static_cast<double>(points_.size() - 1) * dt_s_; }
  double length_m() const { return arcs_.empty() ? 0.0 : arcs_.back(); }

  /// Times and arc lengths outside the trajectory are clamped to it. Precondition of the functions from here on: the
  /// trajectory is not empty.
  geometry::Vec3 position_at(double time_s) const;
  double arc_at(double time_s) const;
  double speed_at(double time_s) const;
  /// Returns the time from which on the trajectory only gets slower until it rests.
  double braking_begins_s() const;
  geometry::Vec3 position_at_arc(double arc_m) const;
  /// Returns the arc length of the point nearest to `position` among those passed between the two times.
  double project(const geometry::Vec3& position, double from_s, double to_s) const;
  /// Returns the points from an arc length on, beginning with the point at it.
  std::vector<geometry::Vec3> points_from_arc(double arc_m) const;

  /// Returns the trajectory from `from_arc_m` on along the same curve, at no more than the same speed and braked to
  /// rest at `stop_arc_m`; nothing if that is too short a way to stop at the given deceleration.
  std::optional<Trajectory> stopped_at(double from_arc_m, double stop_arc_m, double deceleration_mps2) const;

 private:
  double speed_at_arc(double arc_m) const;

  std::vector<geometry::Vec3> points_;
  std::vector<double> arcs_;
  double dt_s_ = 0.0;
};

/// Returns the deceleration that the limits allow everywhere on a trajectory between two arc lengths. Level segments
/// brake by the horizontal limit, others by limits_along(). For the vertical axis the tighter of the two limits counts
/// in both directions, because braking a climb is accelerating downwards.
/// @param velocity  present velocity of the vehicle, whose direction must be braked as well
double braking_deceleration(const Trajectory& trajectory, double from_arc_m, double to_arc_m,
                            const geometry::Vec3& velocity, const DynamicsLimits& limits);

/// Returns the time from rest to rest along a polyline, whose corners are rounded within a tolerance; 0 for less than
/// two points. O(points).
double flight_time(const std::vector<geometry::Vec3>& points, const DynamicsLimits& limits, double corner_tolerance_m);

/// Returns the distance until standstill: the reaction time at constant speed, then constant deceleration.
double stopping_distance(double speed_mps, double deceleration_mps2, double reaction_s);

}  // namespace voxnav::planning
