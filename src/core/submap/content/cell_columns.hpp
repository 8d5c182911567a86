// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

/// Sets the voxels of a cell in the columns of its block.
/// @param voxels  one bit for each voxel of the cell
void add_cell_to_columns(int cell, std::uint64_t voxels, Columns* columns);

}  // namespace voxnav::submap
