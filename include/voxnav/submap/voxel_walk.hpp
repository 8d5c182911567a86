// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdlib>
#include <limits>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// geometry::index_of(p, 1.0) without the calls of std::floor; for coordinates within +-2^30.
inline geometry::Index3 floor_index(const geometry::Vec3& p) {
  const auto floor = [](double c) {
    const auto i = static_cast<std::int32_t>(c);
    return i - static_cast<std::int32_t>(c < i);
  };
  return {floor(p.x()), floor(p.y()), floor(p.z())};
}

/// Calls visit(voxel) for every voxel of the segment from a to b (in voxel edges), in order; stops when it returns
/// false. The number of steps is counted in integers, so rounding can neither overshoot nor loop.
/// Source: Amanatides & Woo 1987.
template <class F>
void walk_voxels(const geometry::Vec3& a, const geometry::Vec3& b, F&& visit) {
  geometry::Index3 at = geometry::index_of(a, 1.0);
  const geometry::Index3 end = geometry::index_of(b, 1.0);
  const geometry::Vec3 d = b - a;
  const double start[3] = {a.x(), a.y(), a.z()};
  std::int32_t* index[3] = {&at.x, &at.y, &at.z};
  int remaining[3] = {std::abs(end.x - at.x), std::abs(end.y - at.y), std::abs(end.z - at.z)};
  double next[3];
  double delta[3];
  int step[3];
  for (int k = 0; k < 3; ++k) {
    step[k] = d[k] > 0.0 ? 1 : -1;
    delta[k] = d[k] != 0.0 ? 1.0 / std::abs(d[k]) : std::numeric_limits<double>::infinity();
    const double boundary = *index[k] + (step[k] > 0 ? 1.0 : 0.0);
    next[k] = remaining[k] > 0 ? (boundary - start[k]) / d[k] : std::numeric_limits<double>::infinity();
  }
  while (visit(at)) {
    const int k = next[0] <= next[1] ? (next[0] <= next[2] ? 0 : 2) : (next[1] <= next[2] ? 1 : 2);
    if (remaining[k] == 0) return;
    *index[k] += step[k];
    next[k] = --remaining[k] > 0 ? next[k] + delta[k] : std::numeric_limits<double>::infinity();
  }
}

}  // namespace voxnav::submap
