// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::occupancy {

/// Distances from a segment to axis-aligned cubes. The squared distance along the segment is convex, so its lowest
/// point and its first crossing of a radius are found by bisection of the slope, exactly to rounding.
class SegmentDistance {
 public:
  SegmentDistance(const geometry::Vec3& a, const geometry::Vec3& b) : a_(a), delta_(b - a), length_(delta_.norm()) {}

  double length() const { return length_; }
  geometry::Vec3 at(double ratio) const { return a_ + ratio * delta_; }

  double distance_to_point(const geometry::Vec3& p) const { return (at(nearest_ratio(p)) - p).norm(); }
  double nearest_ratio(const geometry::Vec3& p) const {
    return length_ > 0.0 ? std::clamp((p - a_).dot(delta_) / (length_ * length_), 0.0, 1.0) : 0.0;
  }

  /// Returns the ratio along the segment, from 0 to 1, at which it is nearest to the cube; the first one if there are
  /// several.
  double nearest_ratio(const geometry::Vec3& center, double half_edge) const {
    if (slope(0.0, center, half_edge) >= 0.0) return 0.0;
    if (slope(1.0, center, half_edge) < 0.0) return 1.0;
    return bisect(0.0, 1.0, [&](double ratio) { return slope(ratio, center, half_edge) >= 0.0; });
  }
  double distance_at(double ratio, const geometry::Vec3& center, double half_edge) const {
    return outside(at(ratio), center, half_edge).norm();
  }
  /// Returns the first ratio at which a ball of `radius` on the segment touches the cube. Precondition: the ball
  /// touches the cube at the ratio `nearest`.
  double first_touch(double nearest, double radius, const geometry::Vec3& center, double half_edge) const {
    if (distance_at(0.0, center, half_edge) <= radius) return 0.0;
    return bisect(0.0, nearest, [&](double ratio) { return distance_at(ratio, center, half_edge) <= radius; });
  }

 private:
  static geometry::Vec3 outside(const geometry::Vec3& p, const geometry::Vec3& center, double half_edge) {
    const geometry::Vec3 d = p - center;
    return d - d.cwiseMax(-half_edge).cwiseMin(half_edge);
  }
  double slope(double ratio, const geometry::Vec3& center, double half_edge) const {
    return outside(at(ratio), center, half_edge).dot(delta_);
  }
  /// Returns the lowest ratio for which a condition holds. Precondition: the condition holds at `high`, and once it
  /// holds at a ratio it holds at all higher ones.
  template <class Holds>
  static double bisect(double low, double high, Holds holds) {
    for (int i = 0; i < 40; ++i) {
      const double middle = 0.5 * (low + high);
      (holds(middle) ? high : low) = middle;
    }
    return high;
  }

  geometry::Vec3 a_;
  geometry::Vec3 delta_;
  double length_;
};

}  // namespace voxnav::occupancy
