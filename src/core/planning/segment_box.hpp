// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/geometry/aabb.hpp"

namespace voxnav::planning {

/// Line segment from a to b; its points are a + t (b - a) with t in [0, 1].
struct Segment {
  geometry::Vec3 a;
  geometry::Vec3 b;
  double length() const { return (b - a).norm(); }
  geometry::Vec3 at(double t) const { return a + t * (b - a); }
};

double squared_distance(const geometry::Vec3& point, const geometry::Aabb& box);

/// Returns the parameter at which the segment is nearest to the box (the first one if it passes through). The squared
/// distance is convex in t, so its minimum is found by bisection of the sign of its derivative.
double nearest_parameter(const Segment& segment, const geometry::Aabb& box);

double squared_distance(const Segment& segment, const geometry::Aabb& box);

/// Returns the first parameter at which the segment comes closer to the box than `distance`, or -1 if it never does.
double first_parameter_within(const Segment& segment, const geometry::Aabb& box, double distance);

}  // namespace voxnav::planning
