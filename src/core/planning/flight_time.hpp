// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/planning/trajectory.hpp"

namespace voxnav::planning {

/// Maximum speed and acceleration along a direction: neither the horizontal nor the vertical component exceeds its
/// limit.
struct AxisLimits {
  double speed_mps;
  double acceleration_mps2;
};
AxisLimits limits_along(const geometry::Vec3& direction, const DynamicsLimits& limits);

/// Returns the time from rest to rest over a straight segment.
double rest_to_rest_time(double length_m, const AxisLimits& limits);

/// Returns the times at which a vehicle that starts and ends at rest passes the points. It slows down at corners, so
/// that a rounded corner stays within the tolerance of the polyline. Forward-backward pass on squared speeds, O(n).
/// Source: Bobrow, Dubowsky & Gibson, International Journal of Robotics Research 1985 (forward-backward pass); the
/// corner speed is derived in docs/maths/planning.md, section Flight time.
std::vector<double> passing_times(const std::vector<geometry::Vec3>& points, const DynamicsLimits& limits,
                                  double corner_tolerance_m);

/// Returns the polyline up to an arc length, with the point at that arc length as its last.
std::vector<geometry::Vec3> cut_at_length(const std::vector<geometry::Vec3>& points, double length_m);

double length_of(const std::vector<geometry::Vec3>& points);

/// Returns the longest beginning of the polyline that can be flown from rest to rest within `max_time_s`. It may end
/// inside a segment.
std::vector<geometry::Vec3> cut_at_time(const std::vector<geometry::Vec3>& points, const DynamicsLimits& limits,
                                        double corner_tolerance_m, double max_time_s);

}  // namespace voxnav::planning
