// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "voxnav/base/check.hpp"
#include "voxnav/submap/compressed_field.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;

/// Rounds -127 to 127 without a call.
std::int8_t rounded(double value) { return static_cast<std::int8_t>(static_cast<int>(value + 128.5) - 128); }

struct LeafPair {
  CompressedField::Leaf leaf;
  CompressedField::Leaf own;  ///< no hits: the voxel is only remembered
  std::uint8_t own_time;
};

std::array<std::int8_t, 3> clamped(const std::array<std::int8_t, 3>& mean) {
  std::array<std::int8_t, 3> out;
  for (std::size_t k = 0; k < 3; ++k) out[k] = std::max<std::int8_t>(mean[k], -127);
  return out;
}

/// Leaves of a block cell by cell, in the order of their voxels, which is also that of their offsets.
std::array<std::vector<LeafPair>, 64> leaves_by_cell(const occupancy::ContentBlock& block) {
  std::array<std::vector<LeafPair>, 64> out;
  int last = -1;
  for (const occupancy::OccupiedLeaf& leaf : block.occupied) {
    const bool fits =
        leaf.offset < geometry::kBlockVolume && leaf.offset > last && block.states.get(leaf.offset) == State::kOccupied;
    if (!fits) throw std::invalid_argument("map content has leaves that do not match its states");
    last = leaf.offset;
    out[static_cast<std::size_t>(CompressedField::cell_of(leaf.offset))].push_back(
        {{clamped(leaf.mean), leaf.hits}, {clamped(leaf.own_mean), leaf.own_hits}, leaf.own_time});
  }
  return out;
}

}  // namespace

CompressedField::CompressedField(const occupancy::MapContent& content, double band) : band_(band) {
  std::vector<const occupancy::ContentBlock*> order;
  for (const occupancy::ContentBlock& block : content.blocks) {
    if (!block.states.all_unknown() || !block.occupied.empty()) order.push_back(&block);
  }
  std::sort(order.begin(), order.end(), [](const auto* a, const auto* b) { return a->index < b->index; });
  blocks_.reserve(order.size());
  leaves_.reserve(content.num_occupied());
  for (const occupancy::ContentBlock* block : order) {
    if (!blocks_.empty() && blocks_.back().index == block->index)
      throw std::invalid_argument("map content has the same block twice");
    add_block(*block);
  }
  shrink();
  link();
}

CompressedField::CompressedField(const std::vector<FilledBlock>& blocks, double band) : band_(band), has_values_(true) {
  for (const FilledBlock& block : blocks) {
    if (!block.states.all_unknown()) add_block(block);
  }
  shrink();
  link();
}

void CompressedField::shrink() {
  blocks_.shrink_to_fit();
  states_.shrink_to_fit();
  near_.shrink_to_fit();
  values_.shrink_to_fit();
  leaves_.shrink_to_fit();
  own_bits_.shrink_to_fit();
  own_leaves_.shrink_to_fit();
  own_times_.shrink_to_fit();
  own_free_.shrink_to_fit();
}

int CompressedField::count_occupied(const CellStates& states) {
  constexpr std::uint64_t kHighBits = 0xAAAAAAAAAAAAAAAAull;
  return __builtin_popcountll(states[0] & kHighBits) + __builtin_popcountll(states[1] & kHighBits);
}

CompressedField::Block CompressedField::new_block(const Index3& index) const {
  Block block;
  block.index = index;
  block.first_states = static_cast<std::uint32_t>(states_.size());
  block.first_near = static_cast<std::uint32_t>(near_.size());
  block.first_own_free = static_cast<std::uint32_t>(own_free_.size());
  return block;
}

/// Bit per voxel of a cell, out of those of its block.
std::uint64_t CompressedField::bits_of_cell(const occupancy::VoxelBits& bits, int cell) {
  std::uint64_t out = 0;
  for (int row = 0; row < 16; ++row) {  // four voxels along x
    const int offset = offset_of(cell, 4 * row);
    out |= ((bits[static_cast<std::size_t>(offset >> 6)] >> (offset & 63)) & 15u) << (4 * row);
  }
  return out;
}

/// A byte holds four voxels along x, in a block and in a cell, so that states move byte by byte.
void CompressedField::add_block(const occupancy::ContentBlock& content) {
  Block block = new_block(content.index);
  std::array<std::uint8_t, geometry::kBlockVolume / 4> bytes;
  std::memcpy(bytes.data(), content.states.words.data(), bytes.size());
  const std::array<std::vector<LeafPair>, kCells> by_cell = leaves_by_cell(content);
  for (int cell = 0; cell < kCells; ++cell) {
    std::array<std::uint8_t, 16> moved;
    const std::uint8_t* from = &bytes[static_cast<std::size_t>(offset_of(cell, 0) / 4)];
    for (std::size_t row = 0; row < moved.size(); ++row) moved[row] = from[(row & 3) * 4 + (row >> 2) * 64];
    CellStates states;
    std::memcpy(states.data(), moved.data(), moved.size());
    const std::vector<LeafPair>& leaves = by_cell[static_cast<std::size_t>(cell)];
    if (count_occupied(states) != static_cast<int>(leaves.size()))
      throw std::invalid_argument("map content has leaves that do not match its states");
    add_cell(cell, states, nullptr, &block);
    add_own_free(cell, bits_of_cell(content.own_free, cell), states, &block);
    for (const LeafPair& pair : leaves) add_leaf(pair.leaf, pair.own, pair.own_time);
  }
  blocks_.push_back(block);
}

void CompressedField::add_block(const FilledBlock& filled) {
  Block block = new_block(filled.index);
  auto leaf = filled.leaves.begin();
  for (int cell = 0; cell < kCells; ++cell) {
    CellStates states{};
    CellValues values;
    values.fill(kNoValue);
    bool has_value = false;
    const std::size_t first_leaf = leaves_.size();
    for (int voxel = 0; voxel < kCells; ++voxel) {
      const int offset = offset_of(cell, voxel);
      const State state = filled.states.get(offset);
      states[voxel >> 5] |= static_cast<std::uint64_t>(state) << (2 * (voxel & 31));
      const float value = filled.values.empty() ? std::nanf("") : filled.values[static_cast<std::size_t>(offset)];
      if (value <= band_) values[voxel] = rounded(std::max(-1.0, value / band_) * 127.0);
      has_value |= value <= band_;
      if (state != State::kOccupied) continue;
      leaf = std::lower_bound(filled.leaves.begin(), filled.leaves.end(), offset,
                              [](const FilledLeaf& l, int o) { return l.offset < o; });
      VOXNAV_CHECK(leaf != filled.leaves.end() && leaf->offset == offset, "an occupied voxel has no leaf");
      leaves_.push_back({leaf->mean, leaf->hits});
    }
    add_cell(cell, states, has_value || leaves_.size() > first_leaf ? &values : nullptr, &block);
  }
  blocks_.push_back(block);
}

void CompressedField::add_cell(int cell, const CellStates& states, const CellValues* values, Block* block) {
  constexpr std::uint64_t kAllFreeWord = 0x5555555555555555ull;
  if (values || count_occupied(states) > 0) {
    block->codes[cell] = static_cast<std::uint8_t>(kFirstNear + block->num_near++);
    near_.push_back(states);
    if (values) values_.push_back(*values);
  } else if (states[0] == kAllFreeWord && states[1] == kAllFreeWord) {
    block->codes[cell] = kAllFree;
  } else if ((states[0] | states[1]) != 0) {
    block->codes[cell] = static_cast<std::uint8_t>(kFirstStates + states_.size() - block->first_states);
    states_.push_back(states);
  }
}

void CompressedField::link() {
  std::uint32_t leaf = 0;
  first_leaf_.clear();
  first_leaf_.reserve(near_.size());
  for (const CellStates& near : near_) {
    first_leaf_.push_back(leaf);
    leaf += static_cast<std::uint32_t>(count_occupied(near));
  }
  own_before_.clear();
  own_before_.reserve(own_bits_.size());
  std::uint32_t own = 0;
  for (const std::uint64_t word : own_bits_) {
    own_before_.push_back(own);
    own += static_cast<std::uint32_t>(__builtin_popcountll(word));
  }
  std::size_t size = 16;
  while (size < 2 * blocks_.size()) size *= 2;
  table_.assign(size, -1);
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    block.occupied_cells = 0;
    block.num_near = 0;
    for (int cell = 0; cell < kCells; ++cell) {
      if (block.codes[cell] < kFirstNear) continue;
      ++block.num_near;
      const CellStates& near = near_[block.first_near + block.codes[cell] - kFirstNear];
      if (count_occupied(near) > 0) block.occupied_cells |= std::uint64_t{1} << cell;
    }
    block.has_own = has_values_ || (block.own_cells | block.partly_own_cells) != 0 || has_own_leaf(block);
    std::size_t slot = geometry::Index3Hash{}(block.index) & (size - 1);
    while (table_[slot] >= 0) slot = (slot + 1) & (size - 1);
    table_[slot] = static_cast<std::int32_t>(i);
  }
}

}  // namespace voxnav::submap
