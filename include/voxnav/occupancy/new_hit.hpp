// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// A voxel that the newest scan hit, and that the map believed to be free when it was first hit a short time ago.
struct NewHit {
  geometry::Index3 voxel;
  geometry::Vec3f point;         ///< mean of the returns in it [m]
  std::uint16_t num_points = 0;  ///< returns in it, saturates
  bool is_first = false;         ///< no earlier scan hit it
  /// The voxel was free beyond doubt, and there was no surface beside it. Where there is, a new hit shows most likely
  /// more of that surface: rays that graze the ground or pass beside leaves make voxels free which hold both.
  bool is_clear = false;
  containers::VoxelState state = containers::VoxelState::kFree;  ///< after the scan: one hit may leave it free
};

/// What became of a voxel that was hit a short time ago, when it was believed to be free.
struct NewVoxelSight {
  std::uint32_t scans_since_hit = 0;
  bool is_seen_through = false;  ///< since the last hit a scan saw through the surface in it
};

}  // namespace voxnav::occupancy
