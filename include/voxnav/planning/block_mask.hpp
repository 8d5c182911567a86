// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstdint>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::planning {

/// One bit for each voxel of a block, in the order of geometry::offset_in_block(). Unlike std::bitset it shows its
/// words, so that many voxels are looked at at once.
class BlockMask {
 public:
  static constexpr std::size_t kNumWords = geometry::kBlockVolume / 64;

  bool operator[](std::size_t offset) const { return (words_[offset / 64] >> (offset % 64) & 1u) != 0; }
  void set(std::size_t offset) { words_[offset / 64] |= std::uint64_t{1} << (offset % 64); }
  void reset(std::size_t offset) { words_[offset / 64] &= ~(std::uint64_t{1} << (offset % 64)); }
  /// Sets all bits.
  void set() { words_.fill(~std::uint64_t{0}); }
  /// Sets the bits of a layer of voxels, all of the same height in the block.
  void set_layer(int z) {
    const auto first = words_.begin() + z * kWordsPerLayer;
    std::fill(first, first + kWordsPerLayer, ~std::uint64_t{0});
  }

  bool any() const { return !none(); }
  bool none() const { return are_all(0); }
  bool all() const { return are_all(~std::uint64_t{0}); }
  BlockMask& operator|=(const BlockMask& other) {
    for (std::size_t i = 0; i < kNumWords; ++i) words_[i] |= other.words_[i];
    return *this;
  }
  /// Bit i of word w is that of the voxel at offset 64 w + i.
  const std::array<std::uint64_t, kNumWords>& words() const { return words_; }

 private:
  static constexpr int kWordsPerLayer = geometry::kBlockSide * geometry::kBlockSide / 64;

  bool are_all(std::uint64_t value) const {
    return std::all_of(words_.begin(), words_.end(), [value](std::uint64_t word) { return word == value; });
  }

  std::array<std::uint64_t, kNumWords> words_{};
};

}  // namespace voxnav::planning
