// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/occupancy/beam_image.hpp"
#include "voxnav/occupancy/scan_part.hpp"
#include "voxnav/occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// When a beam that crosses a voxel with hits counts against it (see LocalMapConfig).
struct MissGuard {
  float sigmas = 2.0f;
  float spread_voxels = 0.05f;
  float end_voxels = 1.5f;
  int octants = 7;
  int patience = 8;
};

/// Decides whether the beams of a scan saw through the surface in a voxel: past a thin pole in the same voxel they say
/// nothing about it, and grazing the ground they say nothing about the ground.
class SurfaceSight {
 public:
  SurfaceSight(const BeamImage& beams, const ScanFrame& frame, float resolution_m, const MissGuard& guard);
  /// True when the scan refutes the voxel at `center` (window coordinates); notes in the leaf what it saw.
  bool refutes(const geometry::Vec3f& center, SurfaceLeaf* leaf) const;

 private:
  /// Octants of the voxel that a beam went through behind nothing; all of them when it met where the hits were.
  std::uint8_t octants_seen(const geometry::Vec3f& to_center, const SurfaceLeaf& leaf, const geometry::Vec3f& direction,
                            float length) const;

  const BeamImage& beams_;
  geometry::Vec3f origin_;
  Eigen::Matrix3f rotation_;  ///< frame L to the window's axes, no scale
  float resolution_m_;
  MissGuard guard_;
};

}  // namespace voxnav::occupancy
