// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/block_states.hpp"

#include <algorithm>
#include <utility>

#include "submap/content/cell_columns.hpp"

namespace voxnav::submap {

using containers::VoxelState;
using geometry::Index3;

VoxelState BlockStates::state(const Index3& voxel) const {
  const auto position = find(geometry::block_of(voxel));
  return position ? state(*position, geometry::offset_in_block(voxel)) : VoxelState::kUnknown;
}

VoxelState BlockStates::state(std::size_t position, int offset) const {
  const Block& block = blocks_[position];
  const int cell = cell_of(offset);
  const int voxel = voxel_in_cell(offset);
  if (has_bit(occupied_of(block, cell), voxel)) return VoxelState::kOccupied;
  return has_bit(free_of(block, cell), voxel) ? VoxelState::kFree : VoxelState::kUnknown;
}

ColumnBlock BlockStates::columns(std::size_t position) const {
  ColumnBlock out;
  for_each_known_cell(position, ~std::uint64_t{0},
                      [&](int cell, std::uint64_t free, std::uint64_t occupied, std::size_t) {
                        add_cell_to_columns(cell, free, &out.free);
                        if (occupied != 0) add_cell_to_columns(cell, occupied, &out.occupied);
                      });
  return out;
}

Columns BlockStates::observed_free(std::size_t position) const {
  const Block& block = blocks_[position];
  Columns out{};
  kernels::for_each_bit(block.observed_cells | block.partly_observed_cells,
                        [&](int cell) { add_cell_to_columns(cell, observed_free_of(block, cell), &out); });
  return out;
}

bool BlockStates::is_all_free_observed() const {
  return std::all_of(blocks_.begin(), blocks_.end(),
                     [](const Block& b) { return ((b.open_cells | b.mixed_cells) & ~b.observed_cells) == 0; });
}

std::size_t BlockStates::memory_bytes() const {
  const auto bytes = [](const auto&... vectors) { return ((vectors.capacity() * sizeof(vectors[0])) + ...); };
  return bytes(blocks_, occupied_, numbers_, mixed_, observed_free_) + table_.memory_bytes();
}

/// Computes the fields `first_*` of all blocks, whose words lie one after another in the lists, and fills the table.
void BlockStates::take(Parts parts) {
  blocks_ = std::move(parts.blocks);
  occupied_ = std::move(parts.occupied);
  mixed_ = std::move(parts.mixed);
  observed_free_ = std::move(parts.observed_free);
  blocks_.shrink_to_fit();
  occupied_.shrink_to_fit();
  mixed_.shrink_to_fit();
  observed_free_.shrink_to_fit();
  numbers_.clear();
  numbers_.reserve(occupied_.size());
  std::uint32_t number = 0, mixed = 0, partly_observed = 0;
  for (Block& block : blocks_) {
    block.first_occupied = static_cast<std::uint32_t>(numbers_.size());
    block.first_mixed = mixed;
    block.first_partly_observed = partly_observed;
    block.first_number = number;
    mixed += kernels::count_bits(block.mixed_cells);
    partly_observed += kernels::count_bits(block.partly_observed_cells);
    kernels::for_each_bit(block.occupied_cells, [&](int) {
      const std::size_t word = numbers_.size();
      numbers_.push_back(static_cast<std::uint16_t>(number - block.first_number));
      number += kernels::count_bits(occupied_[word]);
    });
  }
  num_occupied_ = number;
  table_.reset(blocks_.size());
  for (std::uint32_t i = 0; i < blocks_.size(); ++i) {
    table_.insert(blocks_[i].index, i, [this](std::uint32_t position) { return index(position); });
  }
}

const char* BlockStates::assign(Parts parts) {
  std::size_t occupied = 0, mixed = 0, partly_observed = 0;
  for (std::size_t i = 0; i < parts.blocks.size(); ++i) {
    const Block& block = parts.blocks[i];
    if (!is_block_in_range(block.index)) return "has a block index out of range";
    if (i > 0 && !(parts.blocks[i - 1].index < block.index)) return "has unsorted blocks";
    if ((block.open_cells & block.mixed_cells) != 0) return "has cells that are free both in part and as a whole";
    if ((block.observed_cells & block.partly_observed_cells) != 0)
      return "has cells that were observed both in part and as a whole";
    occupied += kernels::count_bits(block.occupied_cells);
    mixed += kernels::count_bits(block.mixed_cells);
    partly_observed += kernels::count_bits(block.partly_observed_cells);
  }
  if (occupied != parts.occupied.size() || mixed != parts.mixed.size()) return "has cells that do not match its blocks";
  if (partly_observed != parts.observed_free.size()) return "has observed free space that does not match its cells";
  take(std::move(parts));
  for (const Block& block : blocks_) {
    if (const char* problem = problem_of(block)) return problem;
  }
  return nullptr;
}

const char* BlockStates::problem_of(const Block& block) const {
  for (int cell = 0; cell < kCellsOfBlock; ++cell) {
    const std::uint64_t occupied = occupied_of(block, cell), free = free_of(block, cell);
    if (occupied == 0 && has_bit(block.occupied_cells, cell)) return "has a cell of surfaces without any";
    if ((occupied & free) != 0) return "holds a voxel state that does not exist";
    if (has_bit(block.observed_cells, cell) && free == 0) return "has observed free space in a cell without any";
    if (!has_bit(block.partly_observed_cells, cell)) continue;
    const std::uint64_t observed = observed_free_of(block, cell);
    if (observed == 0 || observed == free || (observed & ~free) != 0)
      return "has observed free space that does not match its states";
  }
  return nullptr;
}

}  // namespace voxnav::submap
