// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/octree_forest.hpp"

namespace voxnav::occupancy {

OctreeForest::OctreeForest(const LocalMapConfig& config)
    : resolution_m(config.resolution_m),
      scale(LogOddsScale::from(config)),
      levels(scale, config.free_threshold, config.occupied_threshold),
      window(config.window_blocks(), config.resolution_m * geometry::kBlockSide) {}

geometry::Vec3 OctreeForest::to_window(const geometry::Vec3& point) const {
  const geometry::Index3 first = window.first_voxel();
  return point / resolution_m - geometry::Vec3(first.x, first.y, first.z);
}

bool OctreeForest::contains(const geometry::Vec3& point) const {
  return window.slot_of(geometry::block_of(geometry::index_of(point, resolution_m))) >= 0;
}

bool OctreeForest::has_surface_beside(const geometry::Index3& voxel) const {
  for (int k = 0; k < 27; ++k) {
    const geometry::Index3 beside = voxel + geometry::Index3{k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1};
    const OctreeBlock* block = window.find(geometry::block_of(beside));
    const int offset = geometry::offset_in_block(beside);
    if (block != nullptr && block->log_odds[offset] > scale.prior && block->new_voxels.find(offset) == nullptr)
      return true;
  }
  return false;
}

void OctreeForest::refresh(int slot) {
  OctreeBlock::Flags flags;
  OctreeBlock* block = window.at(slot);
  block->leaf_flags(levels, &flags);
  block->refresh(flags);
  block->changed_at = sequence;
}

}  // namespace voxnav::occupancy
