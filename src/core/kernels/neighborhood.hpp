// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "kernels/voxel_window.hpp"

namespace voxnav::kernels {

/// Sums over an occupied voxel and its 26 neighbours.
struct Neighborhood {
  std::array<float, 4> towards_free;  ///< sum of unit directions to free voxels, and the number of these
  std::array<float, 4> sum;           ///< sum of x y z of the surface points from the voxel's centre, and their number
  std::array<float, 4> squares;       ///< sums of xx yy zz
  std::array<float, 4> products;      ///< sums of xy yz zx
};

constexpr std::size_t kTogether = 8;  ///< voxels in a batch
using NeighborhoodBatch = std::array<Neighborhood, kTogether>;

/// Computes the neighbourhoods of eight voxels of a window; their neighbours must lie in the window.
void look_around(const VoxelWindow& window, const std::array<geometry::Index3, kTogether>& voxels,
                 NeighborhoodBatch* out);

/// Computes the unit normals, of either sign, of the planes through the surface points around eight voxels, coordinate
/// by coordinate. A normal is zero if the points do not lie in a plane: they are fewer than five, thicker than 0.2
/// voxel edges RMS, or lie along a line.
using PlaneNormals = std::array<std::array<float, kTogether>, 3>;
void fit_planes(const NeighborhoodBatch& batch, PlaneNormals* normals);

namespace reference {
Neighborhood look_around(const VoxelWindow& window, const geometry::Index3& voxel);
std::array<float, 3> fit_plane(const Neighborhood& around);
}  // namespace reference

}  // namespace voxnav::kernels
