// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/scan_box.hpp"

#include <algorithm>

namespace voxnav::occupancy {

ScanBox::ScanBox(const std::array<int, 3>& window_blocks, const geometry::Index3& origin_block, int reach)
    : window_blocks_(window_blocks) {
  const int origin[3] = {origin_block.x, origin_block.y, origin_block.z};
  std::uint32_t stride = geometry::kBlockVolume;
  for (int axis = 0; axis < 3; ++axis) {
    const int low = std::max(0, origin[axis] - reach);
    const int high = std::min(window_blocks[axis] - 1, origin[axis] + reach);
    first_[axis] = static_cast<std::uint32_t>(low);
    size_[axis] = static_cast<std::uint32_t>(high - low + 1);
    parts_[axis].assign(static_cast<std::size_t>(window_blocks[axis]) * geometry::kBlockSide, 0);
    for (int i = low * geometry::kBlockSide; i < (high + 1) * geometry::kBlockSide; ++i) {
      const auto block = static_cast<std::uint32_t>(i >> geometry::kBlockShift) - first_[axis];
      const auto inside = static_cast<std::uint32_t>(i & (geometry::kBlockSide - 1)) << (geometry::kBlockShift * axis);
      parts_[axis][static_cast<std::size_t>(i)] = block * stride + inside;
    }
    stride *= size_[axis];
  }
}

geometry::Index3 ScanBox::first_voxel(std::uint32_t block) const {
  const std::uint32_t x = first_[0] + block % size_[0];
  const std::uint32_t y = first_[1] + block / size_[0] % size_[1];
  const std::uint32_t z = first_[2] + block / size_[0] / size_[1];
  return {static_cast<int>(x) * geometry::kBlockSide, static_cast<int>(y) * geometry::kBlockSide,
          static_cast<int>(z) * geometry::kBlockSide};
}

std::uint32_t ScanBox::slot_of(std::uint32_t block) const {
  const geometry::Index3 voxel = first_voxel(block);
  return static_cast<std::uint32_t>((voxel.x >> 4) +
                                    window_blocks_[0] * ((voxel.y >> 4) + window_blocks_[1] * (voxel.z >> 4)));
}

}  // namespace voxnav::occupancy
