// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/scan_box.hpp"

#include <algorithm>

namespace voxnav::occupancy {

ScanBox::ScanBox(const std::array<int, 3>& window_blocks, const geometry::Index3& origin_block, int reach) {
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
  slots_.reserve(num_blocks());
  first_voxels_.reserve(num_blocks());
  for (std::uint32_t block = 0; block < num_blocks(); ++block) {
    const auto x = static_cast<int>(first_[0] + block % size_[0]);
    const auto y = static_cast<int>(first_[1] + block / size_[0] % size_[1]);
    const auto z = static_cast<int>(first_[2] + block / size_[0] / size_[1]);
    slots_.push_back(static_cast<std::uint32_t>(x + window_blocks[0] * (y + window_blocks[1] * z)));
    first_voxels_.push_back({x * geometry::kBlockSide, y * geometry::kBlockSide, z * geometry::kBlockSide});
  }
}

}  // namespace voxnav::occupancy
