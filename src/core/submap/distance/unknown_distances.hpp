// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "submap/distance/distance_table.hpp"
#include "submap/distance/surface_normals.hpp"

namespace voxnav::submap {

/// Distances of the unknown voxels beside occupied ones, which lie behind the surface mostly. They stay unknown and
/// only serve interpolation in the known voxels next to them. Each takes the plane of the nearest occupied voxel beside
/// it (among 26). Made to be used again for the next block.
class UnknownDistances {
 public:
  /// Finds the occupied voxel nearest to each unknown one.
  void find(const ContentWindow& window);
  /// Occupied voxels in the table and one beside it, by their numbers in the window: those whose planes reach into it.
  const std::vector<std::uint16_t>& near_table() const { return near_table_; }
  /// @param normals  of near_table()
  void write(const ContentWindow& window, const std::vector<SurfaceNormal>& normals, DistanceBlock* out) const;

 private:
  /// Of the row at (y, z) of the table and two around it on every side, so that no neighbour of one beside the table is
  /// beyond.
  static std::size_t row_at(int y, int z) { return static_cast<std::size_t>((y + 3) + (kTableSide + 4) * (z + 3)); }
  void list_unknown(const ContentWindow& window);
  void spread(const ContentWindow::Place& place, const geometry::Vec3f& mean, std::uint16_t number);

  std::vector<std::uint16_t> near_table_;
  std::array<std::uint32_t, (kTableSide + 4) * (kTableSide + 4)> unknown_;  ///< bit x + 8 of each row
  TableOfFloats squared_;                                                   ///< to the nearest surface point
  std::array<std::uint16_t, kTableSize> nearest_;                           ///< its number in near_table_
};

}  // namespace voxnav::submap
