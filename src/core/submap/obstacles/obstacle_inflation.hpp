// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "submap/merged/voxel_units.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// The voxels within reach of the surface points of one block. The window holds the block and 8 voxels around it on
/// every side, as one 32-bit word for each column in which voxel z is bit z + 8. The ball around a point is computed
/// once, although it may reach into several of the 27 blocks.
class BallWindow {
 public:
  static constexpr int kHalo = 8;
  static constexpr int kSide = geometry::kBlockSide + 2 * kHalo;
  /// Limit of the reach, with which balls stay inside the window.
  static constexpr double kMaxReach = 7.0;

  /// Adds every voxel whose centre is nearer than `reach` voxel edges to a surface point. Voxels up to 2e-5 edges
  /// beyond may be added as well, so that rounding never leaves one out.
  /// @param reach  at most kMaxReach
  void add_balls(const EvidenceBlock& block, double reach);
  /// Sets the voxels that the balls reach in the block at `step` (-1, 0 or 1 on each axis) relative to this one.
  void copy_to(const geometry::Index3& step, Columns* mask) const;

 private:
  std::array<std::uint32_t, std::size_t{kSide} * kSide> columns_{};
};

/// Sets the voxels of a block within any reach of the points of another block.
/// @param step  offset from the block of the points to that of the voxels, in blocks
void add_balls(const EvidenceBlock& block, const geometry::Index3& step, double reach, Columns* mask);

}  // namespace voxnav::submap
