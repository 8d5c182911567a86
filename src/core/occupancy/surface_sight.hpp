// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "occupancy/beam_image.hpp"
#include "occupancy/scan_part.hpp"
#include "occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// When a beam that crosses a voxel with hits counts against it (see LocalMapConfig).
struct MissGuard {
  float sigmas = 2.0f;
  float spread_voxels = 0.05f;
  float end_voxels = 1.5f;
  int octants = 8;
  int patience = 8;
};

/// Decides whether the beams of a scan saw through the surface in a voxel: past a thin pole in the same voxel they say
/// nothing about it, and grazing the ground they say nothing about the ground.
class SurfaceSight {
 public:
  SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard);
  /// Which of the `asked` voxels of a block, which must have leaves, the scan refutes; notes in the leaves what it saw.
  /// @param first_voxel  of the block, window coordinates
  VoxelBits refuted(const geometry::Index3& first_voxel, const VoxelBits& asked, SurfaceLeaves* leaves) const;

 private:
  struct Group;
  void judge(const geometry::Vec3f& first_center, Group* group, VoxelBits* out) const;

  const BeamImage& beams_;
  geometry::Vec3f origin_;
  kernels::SightRules rules_;
  MissGuard guard_;
};

}  // namespace voxnav::occupancy
