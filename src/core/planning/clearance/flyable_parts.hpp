// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <utility>
#include <vector>

#include "planning/clearance/block_columns.hpp"

namespace voxnav::planning {

/// The connected parts of the flyable voxels of one block. Parts are numbered from 0 on in the order of their lowest
/// column.
class FlyableParts {
 public:
  static constexpr int kNone = -1;

  /// Finds the parts of a block: voxels that are neighbours through a face belong to one part. O(runs of the columns).
  void assign(const BlockColumns& flyable);

  int size() const { return num_parts_; }
  /// The part that holds a voxel, kNone if it is not flyable. O(1).
  int part_of(const BlockColumns& flyable, int column, int z) const;

  /// Pairs of parts, of this block and of the next one along an axis (0 x, 1 y, 2 z), that touch through their common
  /// face; each pair once, sorted.
  using Contacts = std::vector<std::pair<std::uint16_t, std::uint16_t>>;
  struct Side {
    const BlockColumns* flyable;
    const FlyableParts* parts;
  };
  static Contacts contacts(const Side& low, const Side& high, int axis);
  /// Parts with a voxel at one of the six faces of the block: 0 lowest x, 1 highest x, 2 lowest y, and so on.
  std::vector<std::uint16_t> parts_at_face(const BlockColumns& flyable, int face) const;

  std::size_t memory_bytes() const { return sizeof(*this) + parts_.capacity() * sizeof(std::uint16_t); }

 private:
  std::array<std::uint16_t, kColumns + 1> first_run_{};  ///< number of the lowest run of each column
  std::vector<std::uint16_t> parts_;                     ///< part of each run
  int num_parts_ = 0;
};

/// Calls fn(lowest z, highest z) for each run of set bits of a column, lowest first.
template <class Fn>
void for_each_run(std::uint64_t bits, Fn fn) {
  while (bits != 0) {
    // The carry clears the lowest run and sets the bit above it, if there is one.
    const std::uint64_t carried = bits + (bits & (~bits + 1));
    fn(__builtin_ctzll(bits), carried != 0 ? __builtin_ctzll(carried) - 1 : 63);
    bits &= carried;
  }
}

}  // namespace voxnav::planning
