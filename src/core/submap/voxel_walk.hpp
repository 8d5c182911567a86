// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// Computes geometry::index_of(p, 1.0) without calls of std::floor, for coordinates within +-2^30.
inline geometry::Index3 floor_index(const geometry::Vec3& p) {
  const auto floor = [](double c) {
    const auto i = static_cast<std::int32_t>(c);
    return i - static_cast<std::int32_t>(c < i);
  };
  return {floor(p.x()), floor(p.y()), floor(p.z())};
}

/// Walks over the voxels of the segment from a to b (in voxel edges), in order. The number of steps is counted in
/// integers, so rounding can neither overshoot the end nor loop.
/// Source: Amanatides & Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987.
class VoxelWalk {
 public:
  VoxelWalk(const geometry::Vec3& a, const geometry::Vec3& b) : index_(floor_index(a)) {
    const geometry::Index3 end = floor_index(b);
    const geometry::Vec3 d = b - a;
    const std::int32_t first[3] = {index_.x, index_.y, index_.z};
    const std::int32_t last[3] = {end.x, end.y, end.z};
    for (int k = 0; k < 3; ++k) {
      remaining_[k] = std::abs(last[k] - first[k]);
      step_[k] = d[k] > 0.0 ? 1 : -1;
      delta_[k] = d[k] != 0.0 ? 1.0 / std::abs(d[k]) : kNever;
      const double boundary = first[k] + (step_[k] > 0 ? 1.0 : 0.0);
      next_[k] = remaining_[k] > 0 ? (boundary - a[k]) / d[k] : kNever;
    }
  }

  const geometry::Index3& index() const { return index_; }
  int step(int axis) const { return step_[axis]; }
  /// Returns the position at which the present voxel was entered, from 0 at a to 1 at b.
  double entered() const { return entered_; }
  /// Moves on to the next voxel. @return axis along which it moved, -1 at the end
  int advance() {
    const int k = next_[0] <= next_[1] ? (next_[0] <= next_[2] ? 0 : 2) : (next_[1] <= next_[2] ? 1 : 2);
    if (remaining_[k] == 0) return -1;
    entered_ = next_[k];
    (k == 0 ? index_.x : k == 1 ? index_.y : index_.z) += step_[k];
    next_[k] = --remaining_[k] > 0 ? next_[k] + delta_[k] : kNever;
    return k;
  }

 private:
  static constexpr double kNever = std::numeric_limits<double>::infinity();
  geometry::Index3 index_;
  int remaining_[3];
  int step_[3];
  double next_[3];
  double delta_[3];
  double entered_ = 0.0;
};

}  // namespace voxnav::submap
