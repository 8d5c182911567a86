// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

namespace voxnav::kernels {

/// A window of 32^3 voxels as columns of bits: voxel (x, y, z) is bit z of word x + 32 y.
constexpr int kColumnWindowSide = 32;

struct BallCenter {
  float x, y, z;  ///< voxel edges, centres of voxels being at integers
};

/// Sets every voxel whose centre lies nearer than the reach to one of n centres. The balls must lie inside the window,
/// in voxels 0 to 30 along z, and reach no farther than 7 edges.
void add_balls(const BallCenter* centers, std::size_t n, float squared_reach, std::uint32_t* columns);

namespace reference {
void add_balls(const BallCenter* centers, std::size_t n, float squared_reach, std::uint32_t* columns);
}

}  // namespace voxnav::kernels
