// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// The box of blocks within the window that the rays of one scan can reach. Its blocks are numbered with x fastest.
class ScanBox {
 public:
  ScanBox() = default;
  /// Covers blocks `low` to `high`, both included, counted from the corner of the window.
  ScanBox(const std::array<int, 3>& window_blocks, const geometry::Index3& low, const geometry::Index3& high)
      : window_blocks_(window_blocks),
        low_(low),
        size_{static_cast<std::uint32_t>(high.x - low.x + 1), static_cast<std::uint32_t>(high.y - low.y + 1),
              static_cast<std::uint32_t>(high.z - low.z + 1)} {}

  std::uint32_t num_blocks() const { return size_[0] * size_[1] * size_[2]; }
  /// How many blocks the box has along an axis.
  std::uint32_t size(int axis) const { return size_[static_cast<std::size_t>(axis)]; }
  /// The difference of the numbers of two neighbouring blocks along an axis.
  std::uint32_t block_stride(int axis) const { return axis == 0 ? 1 : axis == 1 ? size_[0] : size_[0] * size_[1]; }
  /// The corner of the box, in voxels from the window's corner.
  geometry::Vec3 corner() const { return geometry::Vec3(low_.x, low_.y, low_.z) * geometry::kBlockSide; }
  /// The position of a block of the box, in blocks from the window's corner.
  geometry::Index3 block_at(std::uint32_t block) const {
    const auto yz = block / size_[0];
    return low_ + geometry::Index3{static_cast<int>(block % size_[0]), static_cast<int>(yz % size_[1]),
                                   static_cast<int>(yz / size_[1])};
  }
  /// The slot that a block of the box has in the window.
  std::uint32_t slot_of(std::uint32_t block) const {
    const geometry::Index3 at = block_at(block);
    return static_cast<std::uint32_t>(at.x + window_blocks_[0] * (at.y + window_blocks_[1] * at.z));
  }
  /// The lowest voxel of a block, counted from the corner of the box.
  geometry::Index3 first_in_box(std::uint32_t block) const {
    const geometry::Index3 at = block_at(block) - low_;
    return {at.x * geometry::kBlockSide, at.y * geometry::kBlockSide, at.z * geometry::kBlockSide};
  }
  /// The lowest voxel of a block, counted from the window's corner.
  geometry::Index3 first_voxel(std::uint32_t block) const {
    const geometry::Index3 at = block_at(block);
    return {at.x * geometry::kBlockSide, at.y * geometry::kBlockSide, at.z * geometry::kBlockSide};
  }

 private:
  std::array<int, 3> window_blocks_{};
  geometry::Index3 low_;
  std::array<std::uint32_t, 3> size_{};
};

}  // namespace voxnav::occupancy
