// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "occupancy/beam_image.hpp"
#include "occupancy/scan_part.hpp"
#include "occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// Limits of the rule by which a beam through a voxel with hits counts against it; LocalMapConfig explains each one.
struct MissGuard {
  float sigmas = 2.0f;
  float spread_voxels = 0.05f;
  float end_voxels = 1.5f;
  int octants = 8;
  int patience = 8;
};

/// Decides whether the beams of a scan saw through the surface in a voxel. A beam that passes beside a thin pole in the
/// same voxel, or grazes the ground, is no evidence against that surface.
class SurfaceSight {
 public:
  SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard);
  /// Returns which of the `asked` voxels of a block the scan refutes, and records what was seen through in their
  /// leaves.
  /// @param first_voxel  lowest voxel of the block, window coordinates
  /// @param asked        voxels to be judged; each of them must have a leaf
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
