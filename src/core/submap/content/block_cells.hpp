// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/bits.hpp"
#include "voxnav/geometry/voxel.hpp"

/// A block of 16^3 voxels is divided into 4^3 cells of 4^3 voxels, so that the states of a cell fit into one word with
/// a bit per voxel. Cells of a block and voxels of a cell are numbered with x fastest, then y, then z.
namespace voxnav::submap {

constexpr int kCellSide = 4;
constexpr int kCellsOfBlock = 64;
constexpr int kVoxelsOfCell = 64;

// An offset in a block is x + 16 y + 256 z: four bits for each axis, of which the upper two number the cell along that
// axis and the lower two the voxel in it.

/// Returns the cell of the voxel with this offset, made of the upper two bits of x, y and z.
inline int cell_of(int offset) { return ((offset >> 2) & 3) | ((offset >> 4) & 12) | ((offset >> 6) & 48); }
/// Returns the number of that voxel in its cell, made of the lower two bits of x, y and z.
inline int voxel_in_cell(int offset) { return (offset & 3) | ((offset >> 2) & 12) | ((offset >> 4) & 48); }
/// Returns the offset in the block of a voxel of a cell; the inverse of cell_of() and voxel_in_cell().
inline int offset_of(int cell, int voxel) {
  return ((cell & 3) << 2) | (voxel & 3) | ((((cell >> 2) & 3) << 2 | ((voxel >> 2) & 3)) << 4) |
         (((cell >> 4) << 2 | (voxel >> 4)) << 8);
}

inline std::uint64_t bit_of(int i) { return std::uint64_t{1} << i; }
inline bool has_bit(std::uint64_t bits, int i) { return (bits >> i) & 1u; }
/// Rank of bit i: the number of set bits below it. Where a list has one record for each set bit, the record of bit i
/// has this index.
inline std::size_t rank_of(std::uint64_t bits, int i) { return kernels::count_bits(bits & (bit_of(i) - 1)); }

/// Gathers the bits at even positions: bit 2 i moves to bit i. Each step closes gaps twice as wide as the step before.
/// Source: Warren, Hacker's Delight, section 7-2 (unshuffle).
inline std::uint64_t gather_even(std::uint64_t bits) {
  bits &= 0x5555555555555555ull;
  bits = (bits | (bits >> 1)) & 0x3333333333333333ull;
  bits = (bits | (bits >> 2)) & 0x0F0F0F0F0F0F0F0Full;
  bits = (bits | (bits >> 4)) & 0x00FF00FF00FF00FFull;
  bits = (bits | (bits >> 8)) & 0x0000FFFF0000FFFFull;
  return (bits | (bits >> 16)) & 0x00000000FFFFFFFFull;
}

/// Reduces the states of a cell, which have two bits per voxel (containers::VoxelState), to one bit per voxel: the
/// lower one
/// (`which` = 0, free) or the upper one (`which` = 1, occupied).
inline std::uint64_t bit_of_each(const std::array<std::uint64_t, 2>& states, int which) {
  return gather_even(states[0] >> which) | gather_even(states[1] >> which) << 32;
}

/// Returns true if the voxel indices of a block and of its neighbours fit into 32 bits.
inline bool is_block_in_range(const geometry::Index3& block) {
  constexpr std::int32_t kLimit = 1 << 26;
  const auto is_in = [](std::int32_t c) { return c >= -kLimit && c < kLimit; };
  return is_in(block.x) && is_in(block.y) && is_in(block.z);
}

}  // namespace voxnav::submap
