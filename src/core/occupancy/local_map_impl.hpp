// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "occupancy/evicted_blocks.hpp"
#include "occupancy/octree_forest.hpp"
#include "occupancy/removed_blocks.hpp"
#include "occupancy/scan_insertion.hpp"
#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {

/// The parts of a local map. Only the sources of LocalMap and the tests of the octree include this header.
struct LocalMap::Impl {
  explicit Impl(const LocalMapConfig& checked)
      : config(checked),
        forest(config),
        insertion(config),
        evicted(config.resolution_m, static_cast<std::size_t>(config.max_evicted_blocks)) {}

  /// Stores the blocks that left the window, so that take_evicted() returns them and changes_since() reports them as
  /// removed.
  void keep(std::vector<EvictedBlock> blocks, InsertStatistics* statistics);
  containers::GridUpdate changes_after(std::uint64_t sequence) const;
  containers::GridUpdate snapshot() const;

  LocalMapConfig config;
  OctreeForest forest;
  ScanInsertion insertion;
  std::vector<BodyBall> bodies;  ///< of other vehicles
  EvictedBlocks evicted;
  RemovedBlocks removed;
  std::vector<geometry::Index3> moving;  ///< voxels that are marked as moving, and some that are not any more
  std::uint64_t num_new_not_kept = 0;    ///< NewVoxels that had no room
  std::uint64_t num_moving_not_kept = 0;
  std::uint64_t taken_at = 0;  ///< sequence number at the last take_changes()
};

}  // namespace voxnav::occupancy
