// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "submap/content/block_states.hpp"

namespace voxnav::submap {

/// Builds BlockStates. Blocks are added in the order of their indices, and the cells of a block in order.
class BlockStatesBuilder {
 public:
  void reserve(std::size_t num_blocks) { parts_.blocks.reserve(num_blocks); }
  void begin_block(const geometry::Index3& index);
  /// @param states  no voxel may be both occupied and free; observed_free counts only for voxels that are free
  void add_cell(int cell, const CellStates& states);
  /// Returns the states and leaves the builder empty.
  BlockStates finish() { return BlockStates(std::exchange(parts_, {})); }

 private:
  BlockStates::Parts parts_;
};

}  // namespace voxnav::submap
