// SPDX-License-Identifier: BSD-3-Clause
// What a submap saw itself, beside all that its local map remembered.
#include <algorithm>

#include "submap/content/compressed_field.hpp"

namespace voxnav::submap {
void CompressedField::add_leaf(const Leaf& leaf, const Leaf& own, std::uint8_t own_time) {
  const std::size_t bit = leaves_.size() & 63;
  if (bit == 0) own_bits_.push_back(0);
  leaves_.push_back(leaf);
  if (own.hits == 0) return;
  own_bits_.back() |= std::uint64_t{1} << bit;
  const std::size_t number = own_times_.size() & 63;
  if (number == 0) changed_bits_.push_back(0);
  own_times_.push_back(own_time);
  if (own == leaf) return;
  changed_bits_.back() |= std::uint64_t{1} << number;
  own_leaves_.push_back(own);
}

CompressedField CompressedField::own_surface() const {
  if (has_values_) return *this;
  CompressedField out;
  out.band_ = band_;
  OwnPlace place{0, 0};
  for (const Block& block : blocks_) {
    Block kept = out.new_block(block.index);
    std::size_t leaf = block.first_leaf;
    for (int cell = 0; cell < kCells; ++cell) {
      std::uint64_t own = 0;
      for (std::uint64_t bits = occupied_of(block, cell); bits != 0; bits &= bits - 1, ++leaf) {
        if (!is_own(leaf)) continue;
        own |= bits & (~bits + 1);
        const std::uint8_t time = own_times_[place.own];
        const Leaf& kept_leaf = next_own(leaf, &place);
        out.add_leaf(kept_leaf, kept_leaf, time);
      }
      out.add_cell(cell, free_of(block, cell), own, nullptr, &kept);
    }
    out.blocks_.push_back(kept);
  }
  out.shrink();
  out.link();
  return out;
}

/// @param own  bit per voxel of the cell; those that are not free do not count
void CompressedField::add_own_free(int cell, std::uint64_t own, std::uint64_t free, Block* block) {
  own &= free;
  if (own == 0) return;
  const std::uint64_t bit = std::uint64_t{1} << cell;
  if (own == free) {
    block->own_cells |= bit;
  } else {
    block->partly_own_cells |= bit;
    own_free_.push_back(own);
  }
}

bool CompressedField::has_memory() const {
  if (has_values_) return false;
  if (own_times_.size() != leaves_.size() || !own_leaves_.empty()) return true;
  const auto is_remembered = [](const Block& b) { return ((b.open_cells | b.mixed_cells) & ~b.own_cells) != 0; };
  return std::any_of(blocks_.begin(), blocks_.end(), is_remembered);
}

CompressedField::OwnPlace CompressedField::own_place(std::size_t leaf) const {
  const auto before = [](const auto& bits, const auto& counts, std::size_t i) {
    if ((i >> 6) == bits.size()) return bits.empty() ? 0u : counts.back() + kernels::count_bits(bits.back());
    return counts[i >> 6] + kernels::count_bits(bits[i >> 6] & ((std::uint64_t{1} << (i & 63)) - 1));
  };
  const std::size_t own = before(own_bits_, own_before_, leaf);
  return {own, before(changed_bits_, changed_before_, own)};
}

bool CompressedField::has_own_leaf(const Block& block, std::size_t num_leaves) const {
  for (std::size_t leaf = block.first_leaf; leaf < block.first_leaf + num_leaves; ++leaf) {
    if (has_values_ || is_own(leaf)) return true;
  }
  return false;
}

}  // namespace voxnav::submap
