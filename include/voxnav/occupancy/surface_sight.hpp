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
  int octants = 8;
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
  struct Beams;
  struct Target;
  bool judge(const geometry::Vec3f& center, SurfaceLeaf* leaf) const;
  bool judge_plain(const geometry::Vec3f& center, SurfaceLeaf* leaf) const;
  bool judge_wide(const geometry::Vec3f& center, SurfaceLeaf* leaf) const;
  std::uint8_t octants_seen(const Target& target, Beams* beams) const;

  const BeamImage& beams_;
  geometry::Vec3f origin_;
  Eigen::Matrix3f rotation_;  ///< metres of frame L to voxel edges along the window's axes
  float resolution_m_;
  float longest_;  ///< beam, voxel edges
  MissGuard guard_;
};

}  // namespace voxnav::occupancy
