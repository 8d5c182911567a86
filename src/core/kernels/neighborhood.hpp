// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "kernels/voxel_window.hpp"

namespace voxnav::kernels {

/// What the 26 voxels around an occupied one, and the voxel itself, say.
struct Neighborhood {
  std::array<float, 4> towards_free;  ///< sum of unit directions to free voxels, and how many these are
  std::array<float, 4> sum;           ///< x y z of the surface points from the voxel's centre, and how many they are
  std::array<float, 4> squares;       ///< xx yy zz
  std::array<float, 4> products;      ///< xy yz zx
};

constexpr std::size_t kTogether = 8;  ///< voxels that are asked at once
using NeighborhoodBatch = std::array<Neighborhood, kTogether>;

/// Looks around eight voxels of a window; the voxels beside them have to lie in it.
void look_around(const VoxelWindow& window, const std::array<WindowVoxel, kTogether>& voxels, NeighborhoodBatch* out);

/// Unit normals of the planes through the surface points around eight voxels, either way up, coordinate by coordinate;
/// zero where the points do not lie in a plane: fewer than five, thicker than 0.2 voxel edges RMS, or along a line.
using PlaneNormals = std::array<std::array<float, kTogether>, 3>;
void fit_planes(const NeighborhoodBatch& batch, PlaneNormals* normals);

namespace reference {
Neighborhood look_around(const VoxelWindow& window, const WindowVoxel& voxel);
std::array<float, 3> fit_plane(const Neighborhood& around);
}  // namespace reference

}  // namespace voxnav::kernels
