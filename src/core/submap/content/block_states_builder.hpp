// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>

#include "submap/content/block_states.hpp"

namespace voxnav::submap {

/// Makes BlockStates, block by block in the order of their indices, cell by cell in order.
class BlockStatesBuilder {
 public:
  void reserve(std::size_t num_blocks) { parts_.blocks.reserve(num_blocks); }
  void begin_block(const geometry::Index3& index);
  /// @param states  occupied and free voxels are different ones; of the observed ones those count that are free
  void add_cell(int cell, const CellStates& states);
  /// The states. The builder is empty afterwards.
  BlockStates finish() { return BlockStates(std::exchange(parts_, {})); }

 private:
  BlockStates::Parts parts_;
};

}  // namespace voxnav::submap
