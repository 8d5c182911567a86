// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// Axis-aligned box; empty until the first extend().
struct Aabb {
  Vec3 min = Vec3::Constant(std::numeric_limits<double>::infinity());
  Vec3 max = Vec3::Constant(-std::numeric_limits<double>::infinity());

  bool empty() const { return (min.array() > max.array()).any(); }
  void extend(const Vec3& point) {
    min = min.cwiseMin(point);
    max = max.cwiseMax(point);
  }
  bool contains(const Vec3& point) const {
    return (point.array() >= min.array()).all() && (point.array() <= max.array()).all();
  }
  bool intersects(const Aabb& other) const {
    return (min.array() <= other.max.array()).all() && (other.min.array() <= max.array()).all();
  }
  Aabb padded(double margin_m) const { return {min.array() - margin_m, max.array() + margin_m}; }
  /// Returns the smallest axis-aligned box in frame A around this box.
  Aabb transformed(const Pose& T_A_B) const;
};

}  // namespace voxnav::geometry
