// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/block_states_builder.hpp"

namespace voxnav::submap {

void BlockStatesBuilder::begin_block(const geometry::Index3& index) {
  BlockStates::Block block;
  block.index = index;
  parts_.blocks.push_back(block);
}

void BlockStatesBuilder::add_cell(int cell, const CellStates& states) {
  BlockStates::Block& block = parts_.blocks.back();
  if (states.occupied != 0) {
    block.occupied_cells |= bit_of(cell);
    parts_.occupied.push_back(states.occupied);
  }
  if (states.free == 0) return;
  if (states.free == ~states.occupied) {
    block.open_cells |= bit_of(cell);
  } else {
    block.mixed_cells |= bit_of(cell);
    parts_.mixed.push_back(states.free);
  }
  const std::uint64_t observed = states.observed_free & states.free;
  if (observed == 0) return;
  if (observed == states.free) {
    block.observed_cells |= bit_of(cell);
  } else {
    block.partly_observed_cells |= bit_of(cell);
    parts_.observed_free.push_back(observed);
  }
}

}  // namespace voxnav::submap
