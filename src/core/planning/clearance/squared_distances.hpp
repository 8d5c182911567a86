// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <vector>

#include "planning/clearance/block_columns.hpp"

namespace voxnav::planning {

/// Largest distance in voxels up to which distances are kept: one block.
constexpr int kMaxReach = geometry::kBlockSide;

/// Squared distances of a block's voxels, in the order z + 16 (x + 16 y).
using ClearanceDistances = std::array<std::int16_t, geometry::kBlockVolume>;

/// The voxels of one kind in a block and the 26 around it, block (dx, dy, dz) at (dx + 1) + 3 (dy + 1) + 9 (dz + 1);
/// null where a block has none or is all of that kind, as `absent_is_set` says.
struct SurroundingColumns {
  std::array<const BlockColumns*, 27> blocks{};
  bool absent_is_set = false;
};

/// Distances from the centres of voxels to the nearest face of a voxel that is set, squared, in units of a quarter of a
/// squared voxel edge.
/// Source: Felzenszwalb & Huttenlocher, Theory of Computing 2012, section 2; here by brute force on two axes, which is
/// faster for radii of a few voxels, and by bits on the third.
class SquaredDistanceTransform {
 public:
  /// @param limit  distances beyond this one, squared, are kFar
  SquaredDistanceTransform(int reach, int limit);

  /// Computes the columns of a range again and leaves the others as they are.
  /// @return false if none of the columns in the range has a set voxel within reach; `out` is kFar there
  bool compute(const SurroundingColumns& set, const ColumnRange& range, ClearanceDistances* out);

  int reach() const { return reach_; }

 private:
  using Column = std::array<std::int16_t, geometry::kBlockSide>;

  void along_z(const SurroundingColumns& set, const ColumnRange& range);
  void along_x(const ColumnRange& range);
  void along_y(const ColumnRange& range, ClearanceDistances* out) const;
  /// The bits of a line that lie within reach of a place in the block, moved so that bit 0 is `reach` below the place.
  std::uint64_t within_reach(std::uint64_t line, int place) const {
    return (line >> place) & ((std::uint64_t{2} << (2 * reach_)) - 1);
  }
  int halo_at(int x, int y) const { return (x + reach_) + (geometry::kBlockSide + 2 * reach_) * (y + reach_); }

  int reach_;
  int limit_;
  std::vector<std::int16_t> weights_;  ///< squared distance to a voxel's face by offset on an axis
  std::vector<Column> heights_;        ///< distances along z, of the range and what surrounds it
  std::vector<Column> rows_;           ///< least of them along x
  // Most columns have nothing within reach: which ones do is kept in words, so that the others cost nothing.
  static constexpr int kMaxSide = geometry::kBlockSide + 2 * kMaxReach;
  static_assert(kMaxSide <= 64, "a word holds a line of columns");
  std::array<std::uint64_t, kMaxSide> has_height_{};           ///< by y + reach: bit x + reach
  std::array<std::uint64_t, geometry::kBlockSide> has_row_{};  ///< by x: bit y + reach
};

}  // namespace voxnav::planning
