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

/// Connected groups (26 neighbours) of at least `min_voxels` voxels that lost their surface to newer free space, or got
/// one where older submaps had seen free space and have no surface beside it (which would be noise of a pose).
/// Appeared first, each kind in the order of its first voxel. O(changed voxels).
std::vector<SceneChange> scene_changes(const EvidenceMap& evidence, std::size_t min_voxels);

}  // namespace voxnav::submap
