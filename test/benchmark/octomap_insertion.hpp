// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/octomap.h>

#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::test {

/// Returns rows of x, y, z around a sensor as the cloud in map axes that OctoMap inserts.
inline octomap::Pointcloud octomap_cloud(const std::vector<float>& rows, const geometry::Vec3& origin) {
  octomap::Pointcloud out;
  const geometry::Vec3f shift = origin.cast<float>();
  for (std::size_t k = 0; k < rows.size(); k += 3) {
    out.push_back(rows[k] + shift.x(), rows[k + 1] + shift.y(), rows[k + 2] + shift.z());
  }
  return out;
}

inline octomap::point3d octomap_point(const geometry::Vec3& p) {
  return {static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z())};
}

}  // namespace voxnav::test
