// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>

#include "voxnav/containers/state_grid.hpp"

namespace voxnav::submap {

/// One bit for each voxel of a block: bit z of the word of column x + 16 y. As submaps rotate about the vertical only,
/// columns stay columns, and sixteen voxels are moved at once.
using Columns = std::array<std::uint16_t, std::size_t{geometry::kBlockSide} * geometry::kBlockSide>;

inline std::size_t column_at(int x, int y) {
  const int column = x + geometry::kBlockSide * y;
  return static_cast<std::size_t>(column);
}

/// The states of a block as columns. A voxel is occupied, else free, else unknown.
struct ColumnBlock {
  Columns free{};
  Columns occupied{};

  containers::VoxelState get(int offset) const {
    const auto column = static_cast<std::size_t>(offset & 255);
    const int z = offset >> 8;
    if ((occupied[column] >> z) & 1) return containers::VoxelState::kOccupied;
    return (free[column] >> z) & 1 ? containers::VoxelState::kFree : containers::VoxelState::kUnknown;
  }
  bool all_unknown() const;
};

/// Converts the states to 2 bits per voxel, x fastest, the form of grids outside of submaps.
containers::StateBlock to_states(const ColumnBlock& block);
ColumnBlock to_columns(const containers::StateBlock& states);

}  // namespace voxnav::submap
