// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/geometry/aabb.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// Something that appeared or disappeared between submaps.
struct SceneChange {
  enum class Kind : std::uint8_t { kAppeared, kDisappeared };
  Kind kind;
  geometry::Aabb box_W;
  geometry::Vec3 center_W;  ///< mean of its surface points
  std::size_t num_voxels = 0;
  std::uint32_t submap_id = 0;  ///< the newest submap that shows the change
};

/// Lists what appeared or disappeared: connected groups (26 neighbours) of at least `min_voxels` voxels whose surface
/// was removed by newer free space, or whose surface is new where older submaps observed free space and have no surface
/// beside it (which would hint at an error of a pose). What appeared comes first, each kind in the order of its first
/// voxel. O(changed voxels).
std::vector<SceneChange> scene_changes(const EvidenceMap& evidence, std::size_t min_voxels);

}  // namespace voxnav::submap
