// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "base/check.hpp"
#include "submap/content/cell_bits.hpp"
#include "submap/content/compressed_field.hpp"

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
    if (!is_block_in_range(block->index)) throw std::invalid_argument("map content has a block index out of range");
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
  free_.shrink_to_fit();
  occupied_.shrink_to_fit();
  values_.shrink_to_fit();
  leaves_.shrink_to_fit();
  own_bits_.shrink_to_fit();
  own_times_.shrink_to_fit();
  changed_bits_.shrink_to_fit();
  own_leaves_.shrink_to_fit();
  own_free_.shrink_to_fit();
}

CompressedField::Block CompressedField::new_block(const Index3& index) const {
  Block block;
  block.index = index;
  block.first_near = static_cast<std::uint32_t>(occupied_.size());
  block.first_free = static_cast<std::uint32_t>(free_.size());
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
    std::array<std::uint64_t, 2> states;
    std::memcpy(states.data(), moved.data(), moved.size());
    const std::uint64_t free = bit_of_each(states, 0), occupied = bit_of_each(states, 1);
    const std::vector<LeafPair>& leaves = by_cell[static_cast<std::size_t>(cell)];
    if (kernels::count_bits(occupied) != leaves.size())
      throw std::invalid_argument("map content has leaves that do not match its states");
    add_cell(cell, free, occupied, nullptr, &block);
    add_own_free(cell, bits_of_cell(content.own_free, cell), free, &block);
    for (const LeafPair& pair : leaves) add_leaf(pair.leaf, pair.own, pair.own_time);
  }
  blocks_.push_back(block);
}

void CompressedField::add_block(const FilledBlock& filled) {
  Block block = new_block(filled.index);
  auto leaf = filled.leaves.begin();
  for (int cell = 0; cell < kCells; ++cell) {
    std::uint64_t free = 0, occupied = 0;
    CellValues values;
    values.fill(kNoValue);
    bool has_value = false;
    for (int voxel = 0; voxel < kCells; ++voxel) {
      const int offset = offset_of(cell, voxel);
      const State state = filled.states.get(offset);
      if (state == State::kFree) free |= std::uint64_t{1} << voxel;
      if (state == State::kOccupied) occupied |= std::uint64_t{1} << voxel;
      const float value = filled.values.empty() ? std::nanf("") : filled.values[static_cast<std::size_t>(offset)];
      if (value <= band_) values[voxel] = rounded(std::max(-1.0, value / band_) * 127.0);
      has_value |= value <= band_;
      if (state != State::kOccupied) continue;
      leaf = std::lower_bound(filled.leaves.begin(), filled.leaves.end(), offset,
                              [](const FilledLeaf& l, int o) { return l.offset < o; });
      VOXNAV_CHECK(leaf != filled.leaves.end() && leaf->offset == offset, "an occupied voxel has no leaf");
      leaves_.push_back({leaf->mean, leaf->hits});
    }
    add_cell(cell, free, occupied, has_value || occupied != 0 ? &values : nullptr, &block);
  }
  blocks_.push_back(block);
}

void CompressedField::add_cell(int cell, std::uint64_t free, std::uint64_t occupied, const CellValues* values,
                               Block* block) {
  const std::uint64_t bit = std::uint64_t{1} << cell;
  if (values || occupied != 0) {
    block->near_cells |= bit;
    occupied_.push_back(occupied);
    if (values) values_.push_back(*values);
  }
  if (free == 0) return;
  if (free == ~occupied) {
    block->open_cells |= bit;
  } else {
    block->mixed_cells |= bit;
    free_.push_back(free);
  }
}

/// Of words of bits: bits before each.
std::vector<std::uint32_t> CompressedField::counts_before(const std::vector<std::uint64_t>& words) {
  std::vector<std::uint32_t> out;
  out.reserve(words.size());
  std::uint32_t count = 0;
  for (const std::uint64_t word : words) {
    out.push_back(count);
    count += kernels::count_bits(word);
  }
  return out;
}

void CompressedField::link() {
  own_before_ = counts_before(own_bits_);
  changed_before_ = counts_before(changed_bits_);
  leaf_offsets_.clear();
  leaf_offsets_.reserve(occupied_.size());
  std::size_t size = 16;
  while (size < 2 * blocks_.size()) size *= 2;
  table_.assign(size, -1);
  std::uint32_t leaf = 0;
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    Block& block = blocks_[i];
    block.first_leaf = leaf;
    std::uint32_t num_leaves = 0;
    const std::size_t end_near = block.first_near + kernels::count_bits(block.near_cells);
    for (std::size_t near = block.first_near; near < end_near; ++near) {
      leaf_offsets_.push_back(static_cast<std::uint16_t>(num_leaves));
      num_leaves += kernels::count_bits(occupied_[near]);
    }
    leaf += num_leaves;
    block.has_own = has_values_ || (block.own_cells | block.partly_own_cells) != 0 || has_own_leaf(block, num_leaves);
    std::size_t slot = geometry::Index3Hash{}(block.index) & (size - 1);
    while (table_[slot] >= 0) slot = (slot + 1) & (size - 1);
    table_[slot] = static_cast<std::int32_t>(i);
  }
}

}  // namespace voxnav::submap
