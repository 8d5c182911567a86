// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// An occupied voxel on its way into a submap.
struct FilledLeaf {
  std::uint16_t offset = 0;           ///< geometry::offset_in_block()
  std::array<std::int8_t, 3> mean{};  ///< surface point from the voxel centre, unit voxel edge / 254
  std::uint8_t hits = 0;
  geometry::Vec3f normal{0.f, 0.f, 0.f};  ///< unit, towards free space, frame G; zero where nothing free is near
  float quality = 0.f;                    ///< confidence in the normal, 0 to 1
};

/// One block as a filling (occupancy or projective) leaves it, before compression. Frame G, the grid of the submap.
struct FilledBlock {
  geometry::Index3 index;
  containers::StateBlock states;
  std::vector<FilledLeaf> leaves;  ///< sorted by offset, exactly the occupied voxels
  std::vector<float> values;       ///< signed distance per voxel in voxel edges, NaN where there is none; or empty
};

}  // namespace voxnav::submap
