// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "occupancy/evicted_blocks.hpp"
#include "occupancy/octree_forest.hpp"
#include "occupancy/removed_blocks.hpp"
#include "occupancy/scan_insertion.hpp"
#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {

/// The parts of a local map. Only its own sources and tests of the octree look at them.
struct LocalMap::Impl {
  explicit Impl(const LocalMapConfig& checked)
      : config(checked),
        forest(config),
        insertion(config),
        evicted(config.resolution_m, static_cast<std::size_t>(config.max_evicted_blocks)) {}

  /// What left the window goes where take_evicted() and the changes find it.
  void keep(std::vector<EvictedBlock> blocks, InsertStatistics* statistics);
  containers::GridUpdate changes_after(std::uint64_t sequence) const;
  containers::GridUpdate snapshot() const;

  LocalMapConfig config;
  OctreeForest forest;
  ScanInsertion insertion;
  EvictedBlocks evicted;
  RemovedBlocks removed;
  std::uint64_t taken_at = 0;  ///< the sequence at the last take_changes()
};

}  // namespace voxnav::occupancy
