// SPDX-License-Identifier: BSD-3-Clause
#include "submap/distance/distance_block.hpp"

#include <algorithm>

namespace voxnav::submap {

bool DistanceBlock::corners(int x, int y, int z, std::array<float, 8>* values) const {
  constexpr std::size_t kRow = kSide, kLayer = kRow * kRow;
  const std::int16_t* low = &codes_[kernels::table_at(x, y, z)];
  for (std::size_t i = 0; i < 8; ++i) {
    const std::int16_t code = low[(i & 1) + kRow * ((i >> 1) & 1) + kLayer * (i >> 2)];
    if (code == kNone) return false;
    (*values)[i] = static_cast<float>(code) * scale_;
  }
  return true;
}

void DistanceBlock::set(int x, int y, int z, float distance) {
  const float code = std::min(32767.f, std::max(-32767.f, distance / scale_));
  codes_[kernels::table_at(x, y, z)] = static_cast<std::int16_t>(code + (code < 0.f ? -0.5f : 0.5f));
}

bool DistanceBlock::is_empty() const {
  return std::all_of(codes_.begin(), codes_.end(), [](std::int16_t code) { return code == kNone; });
}

}  // namespace voxnav::submap
