// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::planning {

/// What the vehicle may do, as mrs_msgs/DynamicsConstraints says.
struct DynamicsLimits {
  double horizontal_speed_mps = 0.0;
  double horizontal_acceleration_mps2 = 0.0;
  double ascending_speed_mps = 0.0;
  double ascending_acceleration_mps2 = 0.0;
  double descending_speed_mps = 0.0;
  double descending_acceleration_mps2 = 0.0;

  /// All positive and finite.
  bool is_valid() const;
};

/// Greatest speed and acceleration along a direction: the tighter of the horizontal and the vertical share.
struct AxisLimits {
  double speed_mps;
  double acceleration_mps2;
};
AxisLimits limits_along(const geometry::Vec3& direction, const DynamicsLimits& limits);

/// Time from rest to rest over a straight length.
double rest_to_rest_time(double length_m, const AxisLimits& limits);

/// Times at which a vehicle that starts and ends at rest passes the points, slowing at corners so that rounding
/// them stays within the tolerance. Forward-backward pass on squared speeds, O(n).
/// Source: Bobrow et al. 1985 (forward-backward pass); corner speed as in trapezoidal machine control.
std::vector<double> passing_times(const std::vector<geometry::Vec3>& points, const DynamicsLimits& limits,
                                  double corner_tolerance_m);

/// Point at an arc length and the polyline up to it.
std::vector<geometry::Vec3> cut_at_length(const std::vector<geometry::Vec3>& points, double length_m);

double length_of(const std::vector<geometry::Vec3>& points);

/// Longest beginning of the polyline that can be flown from rest to rest within `max_time_s`; may end inside a piece.
std::vector<geometry::Vec3> cut_at_time(const std::vector<geometry::Vec3>& points, const DynamicsLimits& limits,
                                        double corner_tolerance_m, double max_time_s);

}  // namespace voxnav::planning
