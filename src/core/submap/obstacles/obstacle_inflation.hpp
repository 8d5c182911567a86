// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "submap/merged/voxel_units.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// The voxels within reach of the surface points of one block: those of the block and 8 around it on every side, one
/// 32-bit word per column, bit z + 8. The ball around a point is computed once, whichever of the 27 blocks it reaches
/// into.
class BallWindow {
 public:
  static constexpr int kHalo = 8;
  static constexpr int kSide = geometry::kBlockSide + 2 * kHalo;
  /// Balls must stay inside the window.
  static constexpr double kMaxReach = 7.0;

  /// Adds every voxel whose centre is nearer than `reach` voxel edges to a surface point; up to 2e-5 edges beyond, so
  /// that rounding never leaves one out. @param reach at most kMaxReach
  void add_balls(const EvidenceBlock& block, double reach);
  /// Sets the voxels of the block at `step` (-1, 0, 1 on each axis) from this one's that the balls reach.
  void copy_to(const geometry::Index3& step, Columns* mask) const;

 private:
  std::array<std::uint32_t, kSide * kSide> columns_{};
};

/// Sets the voxels of a block within reach of the points of another one, for any reach.
/// @param step  from the block of the points to that of the voxels, blocks
void add_balls(const EvidenceBlock& block, const geometry::Index3& step, double reach, Columns* mask);

}  // namespace voxnav::submap
