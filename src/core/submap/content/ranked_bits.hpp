// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "submap/content/block_cells.hpp"

namespace voxnav::submap {

/// A bit vector with constant-time rank, the number of set bits before a position. It serves lists in which only some
/// of the items have a further record: the bit tells whether an item has one, and the rank is the index of that record.
/// There is one count for every 64 bits, so that an item costs 1.5 bits.
/// Source: Jacobson, Space-efficient static trees and graphs, FOCS 1989 (rank).
class RankedBits {
 public:
  void push_back(bool bit) {
    if (size_ % 64 == 0) words_.push_back(0);
    words_.back() |= std::uint64_t{bit} << (size_ % 64);
    ++size_;
  }
  /// Computes the counts; to be called after the last push_back() and before rank() or count().
  void finish();
  /// Takes bits that were read. @return false if the words do not fit the counts
  bool assign(std::vector<std::uint64_t> words, std::size_t size, std::size_t count);

  std::size_t size() const { return size_; }
  bool test(std::size_t i) const { return (words_[i / 64] >> (i % 64)) & 1u; }
  /// Returns the number of set bits before position i, which may be the end.
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
  std::vector<std::uint32_t> before_;  ///< number of set bits before each word
  std::size_t size_ = 0;
  std::size_t count_ = 0;  ///< number of all set bits
};

}  // namespace voxnav::submap
