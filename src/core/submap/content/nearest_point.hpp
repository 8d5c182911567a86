// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>

#include "submap/content/submap_content.hpp"

namespace voxnav::submap {

/// What distances are measured to: the surface point in an occupied voxel, or the voxel as a cube.
enum class NearestTarget : std::uint8_t { kSurfacePoint, kVoxelCube };

/// The nearest point of all occupied voxels.
struct NearestPoint {
  geometry::Vec3 point;
  double squared = 0.0;  ///< distance to that point
};

/// Returns the point of an occupied voxel that is nearest to p within `max_distance`, exactly. Lengths are voxel edges.
/// O(blocks within reach).
std::optional<NearestPoint> find_nearest(const SubmapContent& content, const geometry::Vec3& p, double max_distance,
                                         NearestTarget target);

}  // namespace voxnav::submap
