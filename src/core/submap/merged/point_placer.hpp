// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "submap/merged/placed_points.hpp"

namespace voxnav::submap {

/// Lays surface points of a submap into the grid of W, block by block: what the points of a block have in common is
/// computed once. Coordinates are fixed-point numbers, which costs less than rounding floats and gives the same result
/// on every machine.
class PointPlacer {
 public:
  /// @param T_W_G  from voxel edges of the submap to voxel edges of W: one, or one for each time of the submap
  PointPlacer(const std::vector<Eigen::Affine3d>& T_W_G, PlacedPoints* points);

  /// Names the block whose points come next.
  void enter(const geometry::Index3& block_G);
  /// Sets where the next point is in W and adds it. @param offset  of its voxel in the submap's block
  /// @param time  when it was seen, 0 to 255 from the submap's beginning to its end
  /// @param next  PlacedPoints::next(), with everything else filled in
  void place(int offset, std::uint8_t time, SurfaceEvidence* next);

 private:
  using Fixed3 = std::array<std::int64_t, 3>;  // parts of units of W (kUnitShift)

  struct Frame {
    Eigen::Affine3d T_W_G;
    std::array<Fixed3, 3> steps;  ///< where one unit along each axis of the submap leads in W
    Fixed3 origin{};              ///< corner of the block, from that of the lowest block of W that it touches
    std::uint32_t entered = 0;    ///< number of the block that the origin is of
  };
  const Frame& frame_at(std::uint8_t time);
  std::int32_t number_of(const geometry::Index3& step);

  std::vector<Frame> frames_;
  PlacedPoints* points_;
  std::uint32_t num_entered_ = 0;
  geometry::Vec3 corner_G_;            ///< corner of the block, voxel edges
  geometry::Index3 first_W_;           ///< lowest block of W that it touches
  geometry::Index3 sides_;             ///< how many blocks of W it touches along each axis
  std::vector<std::int32_t> numbers_;  ///< numbers of these blocks in PlacedPoints; -1 = not looked up yet
};

}  // namespace voxnav::submap
