// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "voxnav/containers/state_grid.hpp"

namespace voxnav::submap {

/// One bit per voxel of a block: for each column x + 16 y a word with bit z. Submaps turn about the vertical only, so
/// that columns stay columns and sixteen voxels are moved at once.
using Columns = std::array<std::uint16_t, geometry::kBlockSide * geometry::kBlockSide>;

/// The states of a block as columns. A voxel is occupied, else free, else unknown.
struct ColumnBlock {
  Columns free{};
  Columns occupied{};

  containers::State get(int offset) const {
    const auto column = static_cast<std::size_t>(offset & 255);
    const int z = offset >> 8;
    if ((occupied[column] >> z) & 1) return containers::State::kOccupied;
    return (free[column] >> z) & 1 ? containers::State::kFree : containers::State::kUnknown;
  }
  bool all_unknown() const;
};

/// The same states with 2 bits per voxel, x fastest, as grids outside of submaps have them.
containers::StateBlock to_states(const ColumnBlock& block);
ColumnBlock to_columns(const containers::StateBlock& states);

}  // namespace voxnav::submap
