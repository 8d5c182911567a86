// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <random>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::test {

inline geometry::Pose at(double x, double y, double z) {
  geometry::Pose pose = geometry::Pose::Identity();
  pose.translation() = geometry::Vec3(x, y, z);
  return pose;
}

/// Inserts points given in frame W as a scan of a sensor at `origin`.
inline occupancy::InsertStatistics insert_from(occupancy::LocalMap* map, const geometry::Vec3& origin,
                                               const std::vector<geometry::Vec3>& points_W) {
  std::vector<float> points;
  for (const geometry::Vec3& p : points_W) {
    for (int axis = 0; axis < 3; ++axis) points.push_back(static_cast<float>(p[axis] - origin[axis]));
  }
  return map->insert(geometry::view_of_rows(points), at(origin.x(), origin.y(), origin.z()));
}

inline std::vector<geometry::Vec3> random_points(unsigned seed, int n, const geometry::Vec3& center, double reach) {
  std::mt19937 rng(seed);
  std::uniform_real_distribution<double> uniform(-reach, reach);
  std::vector<geometry::Vec3> out;
  for (int i = 0; i < n; ++i) {
    const double x = uniform(rng);
    const double y = uniform(rng);
    out.emplace_back(center + geometry::Vec3(x, y, 0.4 * uniform(rng)));
  }
  return out;
}

}  // namespace voxnav::test
