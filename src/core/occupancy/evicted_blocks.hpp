// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>

#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::occupancy {

/// The content that left the window of a local map and was not handed over yet, in a bounded number of blocks.
class EvictedBlocks {
 public:
  EvictedBlocks(double resolution_m, std::size_t max_blocks) : resolution_m_(resolution_m), max_blocks_(max_blocks) {}

  /// Adds a block that left the window. If the same block has left before, the newer content wins voxel by voxel. A
  /// further block beyond the bound is dropped and counted.
  void add(ContentBlock block);
  /// Returns all blocks in the order of their indices, and forgets them.
  MapContent take();
  void clear() { blocks_.clear(); }

  std::size_t size() const { return blocks_.size(); }
  std::size_t num_dropped() const { return num_dropped_; }
  std::size_t memory_bytes() const;

 private:
  double resolution_m_;
  std::size_t max_blocks_;
  std::size_t num_dropped_ = 0;
  std::map<geometry::Index3, ContentBlock> blocks_;
};

}  // namespace voxnav::occupancy
