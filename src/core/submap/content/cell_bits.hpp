// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// Whether the voxels of a block and of those around it can be counted in 32 bits.
inline bool is_block_in_range(const geometry::Index3& block) {
  constexpr std::int32_t kLimit = 1 << 26;
  const auto is_in = [](std::int32_t c) { return c >= -kLimit && c < kLimit; };
  return is_in(block.x) && is_in(block.y) && is_in(block.z);
}

/// Moves bit 2 i to bit i.
inline std::uint64_t gather_even(std::uint64_t bits) {
  bits &= 0x5555555555555555ull;
  bits = (bits | (bits >> 1)) & 0x3333333333333333ull;
  bits = (bits | (bits >> 2)) & 0x0F0F0F0F0F0F0F0Full;
  bits = (bits | (bits >> 4)) & 0x00FF00FF00FF00FFull;
  bits = (bits | (bits >> 8)) & 0x0000FFFF0000FFFFull;
  return (bits | (bits >> 16)) & 0x00000000FFFFFFFFull;
}

/// One of the two bits of each voxel of a cell.
inline std::uint64_t bit_of_each(const std::array<std::uint64_t, 2>& states, int bit) {
  return gather_even(states[0] >> bit) | gather_even(states[1] >> bit) << 32;
}

}  // namespace voxnav::submap
