// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "submap/merged/placed_points.hpp"

namespace voxnav::submap {

/// Places the surface points of a submap in the grid of W, block by block, so that what the points of a block have in
/// common is computed once. Coordinates are fixed-point numbers, which are faster than rounding floats and give the
/// same result on every machine.
class PointPlacer {
 public:
  /// @param T_W_G  transform from voxel edges of the submap to voxel edges of W: one, or one for each time of the
  /// submap
  PointPlacer(const std::vector<Eigen::Affine3d>& T_W_G, PlacedPoints* points);

  /// Begins the block whose points are placed next.
  void enter(const geometry::Index3& block_G);
  /// Computes the place of a point in W and adds it.
  /// @param offset  offset of its voxel in the submap's block
  /// @param time    time at which it was seen, from 0 at the submap's beginning to 255 at its end
  /// @param next    PlacedPoints::next(), with everything but the place filled in
  void place(int offset, std::uint8_t time, SurfaceEvidence* next);

 private:
  using Fixed3 = std::array<std::int64_t, 3>;  // parts of units of W (kUnitShift)

  struct Frame {
    Eigen::Affine3d T_W_G;
    std::array<Fixed3, 3> steps;  ///< step in W for one unit along each axis of the submap
    Fixed3 origin{};              ///< corner of the block, relative to the lowest block of W that it touches
    std::uint32_t entered = 0;    ///< number of the block for which the origin was computed
  };
  const Frame& frame_at(std::uint8_t time);
  std::int32_t number_of(const geometry::Index3& step);

  std::vector<Frame> frames_;
  PlacedPoints* points_;
  std::uint32_t num_entered_ = 0;
  geometry::Vec3 corner_G_;            ///< corner of the block, voxel edges
  geometry::Index3 first_W_;           ///< lowest block of W that it touches
  geometry::Index3 sides_;             ///< number of blocks of W that it touches along each axis
  std::vector<std::int32_t> numbers_;  ///< numbers of these blocks in PlacedPoints; -1 = not looked up yet
};

}  // namespace voxnav::submap
