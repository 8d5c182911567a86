// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "submap/distance/distance_table.hpp"
#include "submap/distance/surface_normals.hpp"

namespace voxnav::submap {

/// Distances of the unknown voxels beside occupied ones, which mostly lie behind the surface. The voxels stay unknown;
/// their distances only serve interpolation in the known voxels next to them. Each gets the distance to the plane of
/// the nearest occupied voxel among its 26 neighbours. The working memory is kept for the next block.
class UnknownDistances {
 public:
  /// Finds the occupied voxel nearest to each unknown one.
  void find(const ContentWindow& window);
  /// Numbers in the window of the occupied voxels in the table or one voxel beside it, whose planes are needed.
  const std::vector<std::uint16_t>& near_table() const { return near_table_; }
  /// Writes the distances of the unknown voxels.
  /// @param normals  normals of the voxels of near_table()
  void write(const ContentWindow& window, const std::vector<SurfaceNormal>& normals, DistanceBlock* out) const;

 private:
  static constexpr int kRows = kTableSide + 4;  ///< along y and along z
  /// Index of the row at (y, z). There are two rows more on every side of the table, so that the neighbours of a voxel
  /// beside the table have rows as well.
  static std::size_t row_at(int y, int z) {
    const int row = (y + 3) + kRows * (z + 3);
    return static_cast<std::size_t>(row);
  }
  void list_unknown(const ContentWindow& window);
  void spread(const geometry::Index3& voxel, const geometry::Vec3f& mean, std::uint16_t number);

  std::vector<std::uint16_t> near_table_;
  std::array<std::uint32_t, std::size_t{kRows} * kRows> unknown_;  ///< bit x + 8 of each row
  TableOfFloats squared_;                                          ///< squared distance to the nearest point
  std::array<std::uint16_t, kTableSize> nearest_;                  ///< number of that point in near_table_
};

}  // namespace voxnav::submap
