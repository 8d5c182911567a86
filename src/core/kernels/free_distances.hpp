// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "kernels/voxel_window.hpp"

namespace voxnav::kernels {

/// A block and one voxel around it: number x + 1 + 18 (y + 1) + 324 (z + 1), from -1 to 16 on every axis.
constexpr int kTableSide = kWindowBlockSide + 2;
constexpr int kTableVoxels = kTableSide * kTableSide * kTableSide;
constexpr std::int16_t kNoDistance = -32768;

/// Squared distances while they are being made.
using SquaredDistances = std::array<float, kTableVoxels>;

/// For the free voxels of the table whose centre lies within `band` of a surface point (voxel edges) the distance to
/// the nearest one in units of `scale`; kNoDistance for all other voxels of the table. O(points * band^3).
/// @param squared  room that is used on the way
/// @param codes  kTableVoxels of them, kNoDistance before
void measure_free(const VoxelWindow& window, float band, float scale, SquaredDistances* squared, std::int16_t* codes);

namespace reference {
void measure_free(const VoxelWindow& window, float band, float scale, std::int16_t* codes);
}

}  // namespace voxnav::kernels
