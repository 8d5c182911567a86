// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

constexpr int kColumns = geometry::kBlockSide * geometry::kBlockSide;
constexpr std::uint16_t kWholeColumn = 0xFFFF;

/// One bit for each voxel of a block: a word for each column x + 16 y, in it a bit for each z. Worlds are mostly made
/// of things that stand upright, so that most columns are empty or full.
using BlockColumns = std::array<std::uint16_t, kColumns>;

inline int column_at(int x, int y) { return x + geometry::kBlockSide * y; }

/// The voxels of a block that are occupied, and those that are unknown.
void columns_of(const StateBlock& states, BlockColumns* occupied, BlockColumns* unknown);
BlockColumns columns_of(const BlockMask& mask);

/// The columns that are not empty: a word for each y, in it a bit for each x.
std::array<std::uint16_t, geometry::kBlockSide> rows_of(const BlockColumns& columns);

/// Columns x0 <= x < x1, y0 <= y < y1 of a block, or of a block and what surrounds it; none at first.
struct ColumnRange {
  int x0 = 1 << 20;
  int y0 = 1 << 20;
  int x1 = -(1 << 20);
  int y1 = -(1 << 20);

  bool empty() const { return x0 >= x1 || y0 >= y1; }
  void extend(const ColumnRange& other);
  /// The part of the range grown by `margin` that lies in the block at (dx, dy) blocks from this one, in its columns.
  ColumnRange reach(int margin, int dx, int dy) const;
  static ColumnRange whole() { return {0, 0, geometry::kBlockSide, geometry::kBlockSide}; }
};

}  // namespace voxnav::planning
