// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// A set of blocks as a bitmap of their bounding box: adding a block costs a few instructions, and the blocks are
/// listed in order without sorting.
class BlockMarks {
 public:
  /// @param low, high  corners of the box of blocks that may be marked, both inclusive
  BlockMarks(const geometry::Index3& low, const geometry::Index3& high);
  /// Returns true if a box is small enough for a bitmap.
  static bool fits(const geometry::Index3& low, const geometry::Index3& high);

  void mark(const geometry::Index3& block) {
    const std::size_t bit = at(block);
    words_[bit >> 6] |= std::uint64_t{1} << (bit & 63);
  }
  bool is_marked(const geometry::Index3& block) const {
    const std::size_t bit = at(block);
    return (words_[bit >> 6] >> (bit & 63)) & 1;
  }
  /// The marked blocks in the order of geometry::Index3.
  std::vector<geometry::Index3> sorted() const;

 private:
  std::size_t at(const geometry::Index3& block) const {
    const geometry::Index3 i = block - low_;
    return static_cast<std::size_t>(i.x) + size_x_ * (static_cast<std::size_t>(i.y) + size_y_ * i.z);
  }

  geometry::Index3 low_;
  std::size_t size_x_, size_y_;
  std::vector<std::uint64_t> words_;
};

/// Sorts blocks and removes duplicates; by a bitmap instead of comparisons if they lie close enough together.
void sort_unique(std::vector<geometry::Index3>* blocks);

/// Returns the blocks and all their neighbours up to `reach` blocks away on every axis; sorted, without duplicates.
void dilate(int reach, std::vector<geometry::Index3>* blocks);

}  // namespace voxnav::submap
