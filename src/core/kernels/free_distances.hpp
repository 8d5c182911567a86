// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "kernels/voxel_window.hpp"

namespace voxnav::kernels {

/// The table of a block with a border of one voxel: voxel (x, y, z), from -1 to 16 on every axis, has the number
/// x + 1 + 18 (y + 1) + 324 (z + 1).
constexpr int kTableSide = kWindowBlockSide + 2;
constexpr int kTableVoxels = kTableSide * kTableSide * kTableSide;
constexpr std::int16_t kNoDistance = -32768;

inline std::size_t table_at(int x, int y, int z) {
  const int number = (x + 1) + kTableSide * ((y + 1) + kTableSide * (z + 1));
  return static_cast<std::size_t>(number);
}

/// Squared distances while they are computed.
using SquaredDistances = std::array<float, kTableVoxels>;

/// Computes, for the free voxels of the table whose centre lies within `band` of a surface point (voxel edges), the
/// distance to the nearest surface point in units of `scale`. O(points * band^3).
/// @param squared  working memory
/// @param codes    receives the distances; kTableVoxels numbers that are kNoDistance before the call and stay so for
///                 all other voxels
void measure_free(const VoxelWindow& window, float band, float scale, SquaredDistances* squared, std::int16_t* codes);

namespace reference {
void measure_free(const VoxelWindow& window, float band, float scale, std::int16_t* codes);
}

}  // namespace voxnav::kernels
