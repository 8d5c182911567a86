// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// Numbers of voxels, in open addressing; made to be filled anew for every scan without giving its memory back.
class VoxelTable {
 public:
  /// Forgets everything and makes room for `count` voxels.
  void reset(std::size_t count) {
    std::size_t size = 64;
    while (size < 2 * count) size *= 2;
    slots_.assign(size, {{0, 0, 0}, kEmpty});
  }
  /// Number of a voxel; `number` from now on if it has none.
  std::uint32_t insert(const geometry::Index3& voxel, std::uint32_t number) {
    const std::size_t mask = slots_.size() - 1;
    std::size_t i = geometry::Index3Hash{}(voxel)&mask;
    while (slots_[i].number != kEmpty && slots_[i].voxel != voxel) i = (i + 1) & mask;
    if (slots_[i].number == kEmpty) slots_[i] = {voxel, number};
    return slots_[i].number;
  }

 private:
  static constexpr std::uint32_t kEmpty = 0xFFFFFFFFu;
  struct Slot {
    geometry::Index3 voxel;
    std::uint32_t number;
  };
  std::vector<Slot> slots_;
};

}  // namespace voxnav::submap
