// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

#include "voxnav/occupancy/octree_block.hpp"
#include "voxnav/occupancy/ray_marker.hpp"

namespace voxnav::occupancy {

/// All that one scan says about one block. Null members say nothing.
struct BlockEvidence {
  const RayMarker::Row* rows = nullptr;  ///< 64 of them
  const VoxelBits* through = nullptr;    ///< voxels with earlier hits that rays went through
  const HitVoxel* hits_begin = nullptr;
  const HitVoxel* hits_end = nullptr;
};

struct BlockUpdate {
  std::size_t missed = 0;
  std::size_t became_free = 0;
  std::size_t became_occupied = 0;
};

/// One pass: misses, hits (which win), mean hit points, inner nodes.
BlockUpdate update_block(OctreeBlock* block, const BlockEvidence& evidence, const LogOddsScale& scale,
                         const StateLevels& levels);

}  // namespace voxnav::occupancy
