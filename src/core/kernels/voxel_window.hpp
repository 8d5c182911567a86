// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "voxnav/geometry/voxel.hpp"

/// A block of 16^3 voxels with a halo of 8 voxels, as rows of bits along x: the form in which kernels read a
/// submap::ContentWindow. Coordinates are voxels from the first voxel of the block; centres of voxels are at integers.
namespace voxnav::kernels {

constexpr int kWindowBlockSide = 16;
constexpr int kWindowHalo = 8;
constexpr int kWindowSide = kWindowBlockSide + 2 * kWindowHalo;

/// A surface point as x y z 1 and as y z x 0, so that the products of its coordinates need no shuffles.
using WindowPoint = std::array<float, 8>;

/// The window itself. Voxel (x, y, z) is bit x + kWindowHalo of the row at (y, z).
struct VoxelWindow {
  const std::uint32_t* free_rows;
  const std::uint32_t* occupied_rows;
  const std::uint16_t* first_of_row;  ///< number of the first occupied voxel of each row; the others follow it
  const WindowPoint* points;          ///< the surface points of the occupied voxels, by number
  std::size_t num_points;

  static std::size_t row(int y, int z) {
    const int row = y + kWindowHalo + kWindowSide * (z + kWindowHalo);
    return static_cast<std::size_t>(row);
  }
  std::uint32_t free(int y, int z) const { return free_rows[row(y, z)]; }
  std::uint32_t occupied(int y, int z) const { return occupied_rows[row(y, z)]; }
};

}  // namespace voxnav::kernels
