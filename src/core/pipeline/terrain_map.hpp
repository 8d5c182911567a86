// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav/containers/state_grid.hpp"

namespace voxnav::pipeline {

/// The height of the terrain under a vehicle: in each column of voxels the lowest occupied one, without what rises from
/// the ground on less than a window's width, such as trunks, poles and crowns under which no ground was seen. Known
/// where the map holds something occupied within a window's width, up to kRadius voxels from the vehicle. Immutable.
/// Source: Zhang et al., A progressive morphological filter for removing nonground measurements, IEEE Transactions on
/// Geoscience and Remote Sensing 2003, section II (opening), here with a single window.
class TerrainMap {
 public:
  /// Half the width of the window, and the distance in voxels up to which columns are looked at.
  static constexpr double kWindow_m = 3.0;
  static constexpr int kRadius = 512;

  /// O(blocks of the grid + columns within reach * window in voxels).
  TerrainMap(const containers::StateGrid& grid, const geometry::Vec3& vehicle);

  /// Returns the height of the terrain's surface at a column of voxels; nothing where it is not known.
  std::optional<double> height_m(int x, int y) const;
  /// Returns whether the terrain is known somewhere in a column of blocks.
  bool knows_block(int x, int y) const;

 private:
  /// Heights in voxels, row by row; those that are not known are kUnknown.
  using Heights = std::vector<std::int32_t>;
  void read(const containers::StateGrid& grid, const geometry::Vec3& vehicle);
  /// The least, or the greatest known height within the window around each column.
  template <class Pick>
  Heights filtered(const Heights& in, int reach, Pick pick) const;
  std::int32_t at(int x, int y) const;

  double resolution_m_;
  geometry::Index3 low_{0, 0, 0};  ///< first column
  int width_ = 0;
  int depth_ = 0;
  Heights heights_;
};

}  // namespace voxnav::pipeline
