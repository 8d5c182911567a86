// SPDX-License-Identifier: BSD-3-Clause
// What a submap saw itself, beside all that its local map remembered.
#include "voxnav/submap/compressed_field.hpp"

namespace voxnav::submap {
namespace {

constexpr std::uint64_t kOccupiedBits = 0xAAAAAAAAAAAAAAAAull;  // the higher of the two bits of each voxel

}  // namespace

void CompressedField::add_leaf(const Leaf& leaf, const Leaf& own, std::uint8_t own_time) {
  const std::size_t bit = leaves_.size() & 63;
  if (bit == 0) own_bits_.push_back(0);
  leaves_.push_back(leaf);
  if (own.hits == 0) return;
  own_bits_.back() |= std::uint64_t{1} << bit;
  own_leaves_.push_back(own);
  own_times_.push_back(own_time);
}

CompressedField CompressedField::own_surface() const {
  if (has_values_) return *this;
  CompressedField out;
  out.band_ = band_;
  std::size_t leaf = 0;
  std::size_t own = 0;
  for (const Block& block : blocks_) {
    Block kept = out.new_block(block.index);
    for (int cell = 0; cell < kCells; ++cell) {
      CellStates states = cell_states(block, cell);
      for (std::size_t word = 0; word < states.size(); ++word) {
        for (std::uint64_t bits = states[word] & kOccupiedBits; bits != 0; bits &= bits - 1, ++leaf) {
          if (is_own(leaf)) {
            out.add_leaf(own_leaves_[own], own_leaves_[own], own_times_[own]);
            ++own;
          } else {
            states[word] &= ~(bits & (~bits + 1));
          }
        }
      }
      out.add_cell(cell, states, nullptr, &kept);
    }
    out.blocks_.push_back(kept);
  }
  out.shrink();
  out.link();
  return out;
}

/// One bit per leaf says whether it has an own one too.
void CompressedField::read_own(base::ByteReader* in) {
  own_leaves_.resize(in->get_count(sizeof(Leaf) + 1));
  in->get_raw(own_leaves_.data(), own_leaves_.size() * sizeof(Leaf));
  own_times_.resize(own_leaves_.size());
  in->get_raw(own_times_.data(), own_times_.size());
  if (has_values_) {
    if (!own_leaves_.empty()) in->fail("has own hits beside measured distances");
    return;
  }
  own_bits_.resize((leaves_.size() + 63) / 64);
  in->get_raw(own_bits_.data(), own_bits_.size() * sizeof(std::uint64_t));
  std::size_t count = 0;
  for (const std::uint64_t word : own_bits_) count += static_cast<std::size_t>(__builtin_popcountll(word));
  const bool is_beyond = leaves_.size() % 64 != 0 && (own_bits_.back() >> (leaves_.size() % 64)) != 0;
  if (is_beyond || count != own_leaves_.size()) in->fail("has own hits that do not match its leaves");
}

}  // namespace voxnav::submap
