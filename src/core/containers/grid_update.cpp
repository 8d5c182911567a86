// SPDX-License-Identifier: BSD-3-Clause
#include <cstring>
#include <stdexcept>

#include "voxnav/containers/state_grid.hpp"

namespace voxnav::containers {
namespace {

constexpr std::size_t kBytes = GridUpdate::kBytesPerBlock;

void append(const geometry::Index3& block, std::vector<std::int32_t>* out) {
  out->push_back(block.x);
  out->push_back(block.y);
  out->push_back(block.z);
}

geometry::Index3 index_at(const std::vector<std::int32_t>& list, std::size_t i) {
  return {list[3 * i], list[3 * i + 1], list[3 * i + 2]};
}

/// The indices of voxels have 32 bits, so that the index of a block of 16^3 has four bits less.
bool all_in_range(const std::vector<std::int32_t>& list) {
  constexpr std::int32_t kLimit = 1 << 26;
  for (const std::int32_t i : list) {
    if (i < -kLimit || i >= kLimit) return false;
  }
  return true;
}

bool has_undefined_state(const std::vector<std::uint8_t>& states) {
  for (const std::uint8_t byte : states) {
    if (byte & (byte >> 1) & 0x55u) return true;
  }
  return false;
}

void check(const GridUpdate& update) {
  const std::size_t num_blocks = update.block_indices.size() / 3;
  if (update.block_indices.size() % 3 != 0 || update.removed_block_indices.size() % 3 != 0) {
    throw std::invalid_argument("block indices of a grid update must come in threes");
  }
  if (update.states.size() != num_blocks * kBytes) {
    throw std::invalid_argument("a grid update with " + std::to_string(num_blocks) + " blocks needs " +
                                std::to_string(num_blocks * kBytes) + " bytes of states, has " +
                                std::to_string(update.states.size()));
  }
  if (!all_in_range(update.block_indices) || !all_in_range(update.removed_block_indices)) {
    throw std::invalid_argument("a grid update has a block index beyond +-2^26");
  }
  if (has_undefined_state(update.states)) {
    throw std::invalid_argument("a grid update holds a voxel state that does not exist");
  }
}

}  // namespace

void GridUpdate::add(const geometry::Index3& block, const StateBlock& block_states) {
  append(block, &block_indices);
  const std::size_t start = states.size();
  states.resize(start + kBytes);
  std::memcpy(states.data() + start, block_states.words.data(), kBytes);
}

void GridUpdate::remove(const geometry::Index3& block) { append(block, &removed_block_indices); }

GridUpdate snapshot_of(const StateGrid& grid) {
  GridUpdate out = changes_of(grid, grid.sorted_block_indices());
  out.is_snapshot = true;
  return out;
}

GridUpdate changes_of(const StateGrid& grid, const std::vector<geometry::Index3>& blocks) {
  GridUpdate out;
  for (const geometry::Index3& index : blocks) {
    const StateBlock* block = grid.find_block(index);
    if (block && !block->all_unknown()) {
      out.add(index, *block);
    } else {
      out.remove(index);
    }
  }
  return out;
}

void apply(const GridUpdate& update, StateGrid* grid) {
  check(update);
  if (update.is_snapshot) grid->clear();
  for (std::size_t i = 0; i < update.block_indices.size() / 3; ++i) {
    StateBlock block;
    std::memcpy(block.words.data(), update.states.data() + i * kBytes, kBytes);
    grid->replace_block(index_at(update.block_indices, i), block);
  }
  for (std::size_t i = 0; i < update.removed_block_indices.size() / 3; ++i) {
    grid->erase_block(index_at(update.removed_block_indices, i));
  }
}

}  // namespace voxnav::containers
