// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "occupancy/end_voxels.hpp"
#include "occupancy/octree_block.hpp"
#include "occupancy/surface_sight.hpp"

namespace voxnav::occupancy {

/// All that one scan says about one block.
struct BlockEvidence {
  VoxelBits passed{};            ///< voxels that rays crossed
  geometry::Index3 first_voxel;  ///< window coordinates
  const VoxelBits* hit_bits;     ///< voxels that were hit; null when there are none
  const HitVoxel* hits_begin;
  const HitVoxel* hits_end;
  int scan_number;  ///< number of the scan since the last handover, from 1
};

struct BlockUpdate {
  std::size_t missed = 0;
  std::size_t became_free = 0;
  std::size_t became_occupied = 0;
  bool any_state_changed = false;

  BlockUpdate& operator+=(const BlockUpdate& other) {
    missed += other.missed;
    became_free += other.became_free;
    became_occupied += other.became_occupied;
    return *this;
  }
};

/// Updates a block with the evidence of one scan. Misses are applied first, then hits, so that a voxel that was both
/// crossed and hit counts as hit; hit statistics and inner nodes follow.
BlockUpdate update_block(OctreeBlock* block, const BlockEvidence& evidence, const SurfaceSight& sight,
                         const LogOddsScale& scale, const StateLevels& levels);

}  // namespace voxnav::occupancy
