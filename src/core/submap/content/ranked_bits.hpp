// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "submap/content/block_cells.hpp"

namespace voxnav::submap {

/// A sequence of bits that tells at once how many set bits come before any place: where only some of many items have a
/// further record, the bit says whether and the rank says which. One count per 64 bits, so that it costs 1.5 bits each.
/// Source: Jacobson, Space-efficient static trees and graphs, FOCS 1989 (rank).
class RankedBits {
 public:
  void push_back(bool bit) {
    if (size_ % 64 == 0) words_.push_back(0);
    words_.back() |= std::uint64_t{bit} << (size_ % 64);
    ++size_;
  }
  /// To be called when all bits are there, before rank() or count().
  void finish();
  /// Bits that were written before. @return false when words and counts do not fit
  bool assign(std::vector<std::uint64_t> words, std::size_t size, std::size_t count);

  std::size_t size() const { return size_; }
  bool test(std::size_t i) const { return (words_[i / 64] >> (i % 64)) & 1u; }
  /// Set bits before place i, which may be the end.
  std::size_t rank(std::size_t i) const {
    if (i == size_) return count_;
    return before_[i / 64] + rank_of(words_[i / 64], static_cast<int>(i % 64));
  }
  std::size_t count() const { return count_; }
  const std::vector<std::uint64_t>& words() const { return words_; }
  std::size_t memory_bytes() const {
    return words_.capacity() * sizeof(std::uint64_t) + before_.capacity() * sizeof(std::uint32_t);
  }

 private:
  std::vector<std::uint64_t> words_;
  std::vector<std::uint32_t> before_;  ///< set bits before each word
  std::size_t size_ = 0;
  std::size_t count_ = 0;  ///< of set bits
};

}  // namespace voxnav::submap
