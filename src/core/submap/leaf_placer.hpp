// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/submap/placed_leaves.hpp"

namespace voxnav::submap {

/// Lays surface points of a submap into the grid of W, block by block: what a block has in common is computed once for
/// all of its points. In integers, which costs less than rounding floats and is the same on every machine.
class LeafPlacer {
 public:
  /// @param T_W_G  from voxel edges of the submap to voxel edges of W
  LeafPlacer(const Eigen::Affine3d& T_W_G, PlacedLeaves* leaves);

  /// The block whose points come next.
  void enter(const geometry::Index3& block_G);
  /// Sets where the next leaf is in W and adds it. @param offset  of its voxel in the submap's block
  void place(int offset, const std::array<std::int8_t, 3>& mean, PlacedLeaf* next);

 private:
  using Fixed3 = std::array<std::int64_t, 3>;  // parts of units of W

  Eigen::Affine3d T_W_G_;
  PlacedLeaves* leaves_;
  std::array<Fixed3, 3> steps_;        ///< in W, of one unit along each axis of the submap
  geometry::Index3 first_W_;           ///< lowest block that it touches
  Fixed3 origin_;                      ///< of the block, from the corner of that one
  int side_;                           ///< so many blocks of W it touches along an axis at most
  std::vector<std::int32_t> numbers_;  ///< of these; -1 = not looked up yet
};

}  // namespace voxnav::submap
