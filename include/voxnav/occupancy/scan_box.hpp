// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// The blocks that rays of one scan can reach, within the window, with a bit address for each voxel: address =
/// x_part[x] + y_part[y] + z_part[z], so that neighbouring steps of a ray cost one table look-up each. Bits of one
/// block are contiguous (4096) in voxel order.
class ScanBox {
 public:
  /// Covers `reach` blocks around the origin's block; coordinates are blocks from the window's corner.
  ScanBox(const std::array<int, 3>& window_blocks, const geometry::Index3& origin_block, int reach);
  ScanBox() = default;

  std::uint32_t num_blocks() const { return size_[0] * size_[1] * size_[2]; }
  /// Slot in the window of a block of the box.
  std::uint32_t slot_of(std::uint32_t block) const { return slots_[block]; }
  /// Lowest voxel of a block, from the window's corner.
  const geometry::Index3& first_voxel(std::uint32_t block) const { return first_voxels_[block]; }
  /// Part of the address that a coordinate (voxels from the window's corner) contributes on an axis.
  const std::uint32_t* parts(int axis) const { return parts_[axis].data(); }

 private:
  std::array<std::uint32_t, 3> first_{};
  std::array<std::uint32_t, 3> size_{};
  std::array<std::vector<std::uint32_t>, 3> parts_;
  std::vector<std::uint32_t> slots_;
  std::vector<geometry::Index3> first_voxels_;
};

}  // namespace voxnav::occupancy
