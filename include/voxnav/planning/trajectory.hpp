// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav/planning/flight_time.hpp"

namespace voxnav::planning {

/// Positions at equal time steps; the vehicle rests at the last one.
class Trajectory {
 public:
  Trajectory() = default;
  /// @throws std::invalid_argument when there are no points, one is not finite, or dt_s is not positive
  Trajectory(std::vector<geometry::Vec3> points, double dt_s);

  bool empty() const { return points_.empty(); }
  const std::vector<geometry::Vec3>& points() const { return points_; }
  double dt_s() const { return dt_s_; }
  double duration_s() const { return points_.empty() ? 0.0 : static_cast<double>(points_.size() - 1) * dt_s_; }
  double length_m() const { return arcs_.empty() ? 0.0 : arcs_.back(); }

  /// Times outside are clamped. The trajectory may not be empty for any of these.
  geometry::Vec3 position_at(double time_s) const;
  double arc_at(double time_s) const;
  double speed_at(double time_s) const;
  geometry::Vec3 position_at_arc(double arc_m) const;
  /// Arc length of the point nearest to `position` among those passed between the two times.
  double project(const geometry::Vec3& position, double from_s, double to_s) const;
  /// The points after an arc length, beginning with the point at it.
  std::vector<geometry::Vec3> points_from_arc(double arc_m) const;

  /// The same way and at most the same speed from `from_arc_m` on, braked to rest at `stop_arc_m`.
  /// Nothing when the way is too short to stop at that deceleration.
  std::optional<Trajectory> stopped_at(double from_arc_m, double stop_arc_m, double deceleration_mps2) const;

 private:
  double speed_at_arc(double arc_m) const;

  std::vector<geometry::Vec3> points_;
  std::vector<double> arcs_;
  double dt_s_ = 0.0;
};

/// Deceleration that the limits allow all along a trajectory between two arc lengths. Level pieces brake by the
/// horizontal limit, the others by what limits_along() leaves them; vertically the tighter limit counts, whichever the
/// direction, because braking a climb is accelerating downwards. @param velocity a direction to allow for as well
double braking_deceleration(const Trajectory& trajectory, double from_arc_m, double to_arc_m,
                            const geometry::Vec3& velocity, const DynamicsLimits& limits);

/// Way covered until standstill: reaction time at constant speed, then constant deceleration.
double stopping_distance(double speed_mps, double deceleration_mps2, double reaction_s);

}  // namespace voxnav::planning
