// SPDX-License-Identifier: BSD-3-Clause
// What a submap saw itself, beside all that its local map remembered.
#include "voxnav/submap/compressed_field.hpp"

namespace voxnav::submap {
namespace {

constexpr std::uint64_t kOccupiedBits = 0xAAAAAAAAAAAAAAAAull;  // the higher of the two bits of each voxel

int count(std::uint64_t bits) { return __builtin_popcountll(bits); }

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

/// @param own  bit per voxel of the cell; those that are not free do not count
void CompressedField::add_own_free(int cell, std::uint64_t own, const CellStates& states, Block* block) {
  const std::uint64_t free = free_of(states);
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

/// So many leaves before this one the submap hit itself.
std::size_t CompressedField::num_own_before(std::size_t leaf) const {
  const std::uint64_t below = own_bits_[leaf >> 6] & ((std::uint64_t{1} << (leaf & 63)) - 1);
  return own_before_[leaf >> 6] + static_cast<std::size_t>(count(below));
}

bool CompressedField::has_own_leaf(const Block& block) const {
  if (block.num_near == 0) return false;
  const std::size_t end_near = block.first_near + block.num_near;
  const std::size_t end = end_near < first_leaf_.size() ? first_leaf_[end_near] : leaves_.size();
  for (std::size_t leaf = first_leaf_[block.first_near]; leaf < end; ++leaf) {
    if (has_values_ || is_own(leaf)) return true;
  }
  return false;
}

void CompressedField::write_own_free(base::ByteWriter* out) const {
  for (const Block& block : blocks_) {
    out->put(block.own_cells);
    out->put(block.partly_own_cells);
  }
  out->put<std::uint64_t>(own_free_.size());
  out->put_raw(own_free_.data(), own_free_.size() * sizeof(std::uint64_t));
}

/// Call when the states are known to be sound.
void CompressedField::read_own_free(base::ByteReader* in) {
  std::size_t next = 0;
  for (Block& block : blocks_) {
    block.own_cells = in->get<std::uint64_t>();
    block.partly_own_cells = in->get<std::uint64_t>();
    if ((block.own_cells & block.partly_own_cells) != 0) in->fail("has cells that are own both in part and as a whole");
    next += static_cast<std::size_t>(count(block.partly_own_cells));
  }
  own_free_.resize(in->get_count(sizeof(std::uint64_t)));
  in->get_raw(own_free_.data(), own_free_.size() * sizeof(std::uint64_t));
  if (has_values_ && next != 0) in->fail("has own free space beside measured distances");
  if (next != own_free_.size()) in->fail("has own free space that does not match its cells");
  next = 0;
  for (Block& block : blocks_) {
    block.first_own_free = static_cast<std::uint32_t>(next);
    for (int cell = 0; cell < kCells; ++cell) {
      const std::uint64_t free = free_of(cell_states(block, cell));
      if (((block.own_cells >> cell) & 1u) != 0 && free == 0) in->fail("has own free space in a cell without any");
      if (((block.partly_own_cells >> cell) & 1u) == 0) continue;
      const std::uint64_t own = own_free_[next++];
      if (own == 0 || own == free || (own & ~free) != 0) in->fail("has own free space that does not match its states");
    }
  }
}

/// For files from before own free space was told from remembered one.
void CompressedField::take_all_free() {
  if (has_values_) return;
  for (Block& block : blocks_) {
    for (int cell = 0; cell < kCells; ++cell) add_own_free(cell, ~std::uint64_t{0}, cell_states(block, cell), &block);
  }
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
  std::size_t num_own = 0;
  for (const std::uint64_t word : own_bits_) num_own += static_cast<std::size_t>(count(word));
  const bool is_beyond = leaves_.size() % 64 != 0 && (own_bits_.back() >> (leaves_.size() % 64)) != 0;
  if (is_beyond || num_own != own_leaves_.size()) in->fail("has own hits that do not match its leaves");
}

}  // namespace voxnav::submap
