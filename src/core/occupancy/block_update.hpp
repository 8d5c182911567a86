// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "occupancy/end_voxels.hpp"
#include "occupancy/octree_block.hpp"
#include "occupancy/surface_sight.hpp"

namespace voxnav::occupancy {

/// All that one scan says about one block.
struct BlockEvidence {
  VoxelBits passed{};                    ///< voxels that rays crossed
  geometry::Index3 first_voxel;          ///< window coordinates
  const VoxelBits* hit_bits;             ///< voxels that were hit; null when there are none
  const VoxelBits* body_bits = nullptr;  ///< those of them that are left as they are; null when there are none
  const HitVoxel* hits_begin;
  const HitVoxel* hits_end;
  int scan_number;     ///< number of the scan since the last handover, from 1
  std::uint32_t scan;  ///< OctreeForest::scans
};

/// A hit of the scan in a voxel that is new (NewVoxels).
struct HitOfNew {
  const HitVoxel* hit;
  bool is_first;                 ///< nothing in the voxel was hit before
  bool is_clear;                 ///< NewVoxel::is_clear, which is not known yet at the first hit
  containers::VoxelState state;  ///< of the voxel after the scan
};

struct BlockUpdate {
  std::size_t missed = 0;
  std::size_t became_free = 0;
  std::size_t became_occupied = 0;
  std::size_t new_not_kept = 0;  ///< hits of new voxels of which NewVoxels has no more room
  bool any_state_changed = false;

  BlockUpdate& operator+=(const BlockUpdate& other) {
    missed += other.missed;
    became_free += other.became_free;
    became_occupied += other.became_occupied;
    new_not_kept += other.new_not_kept;
    return *this;
  }
};

/// What update_block() reads beside the block and the evidence.
struct UpdateRules {
  const SurfaceSight& sight;
  const LogOddsScale& scale;
  const StateLevels& levels;
};

/// Updates a block with the evidence of one scan. Misses are applied first, then hits, so that a voxel that was both
/// crossed and hit counts as hit; hit statistics and inner nodes follow.
/// @param hits_of_new  the hits in new voxels are appended
BlockUpdate update_block(OctreeBlock* block, const BlockEvidence& evidence, const UpdateRules& rules,
                         std::vector<HitOfNew>* hits_of_new);

}  // namespace voxnav::occupancy
