// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "occupancy/block_window.hpp"
#include "occupancy/log_odds.hpp"

namespace voxnav::occupancy {

/// The octrees of a local map, one for each block of its window, with the log-odds scale by which their bytes are read.
struct OctreeForest {
  explicit OctreeForest(const LocalMapConfig& config);

  double resolution_m;
  LogOddsScale scale;
  StateLevels levels;
  BlockWindow window;
  int recent_scans = 0;        ///< scans since the last handover; saturates at SurfaceLeaf::kMaxNumber
  std::uint32_t scans = 0;     ///< scans since the beginning; only differences of it count
  std::uint64_t sequence = 0;  ///< see LocalMap::sequence()

  /// Converts a point to voxel edges from the lowest corner of the window.
  geometry::Vec3 to_window(const geometry::Vec3& point) const;
  bool contains(const geometry::Vec3& point) const;
  /// Whether one of the 26 neighbours of a voxel is believed to hold a surface, and is not new itself (NewVoxels).
  bool has_surface_beside(const geometry::Index3& voxel) const;
  /// Recomputes the inner nodes of a block from its voxels, and marks the block as changed.
  void refresh(int slot);
  /// Calls f(index, block) for each block that exists, in the order of their indices.
  template <class F>
  void for_blocks(const F& f) const {
    for (int slot = 0; slot < window.num_slots(); ++slot) {
      if (const OctreeBlock* block = window.at(slot)) f(window.block_at(slot), *block);
    }
  }
};

}  // namespace voxnav::occupancy
