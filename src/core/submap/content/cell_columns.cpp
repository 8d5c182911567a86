// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/cell_columns.hpp"

#include <cstring>

#include "submap/content/block_cells.hpp"

namespace voxnav::submap {
namespace {

/// Spreads bits apart: bit i moves to bit 4 i. Each step halves the groups of bits and puts gaps between them.
std::uint64_t spread_by_four(std::uint64_t bits) {
  bits = (bits | (bits << 24)) & 0x000000FF000000FFull;
  bits = (bits | (bits << 12)) & 0x000F000F000F000Full;
  bits = (bits | (bits << 6)) & 0x0303030303030303ull;
  return (bits | (bits << 3)) & 0x1111111111111111ull;
}

/// The sixteen columns of a cell, four bits each, x fastest. The voxels come in four layers of 16, one for each z;
/// voxel i of layer z becomes bit z of column i.
std::uint64_t columns_of_cell(std::uint64_t voxels) {
  return spread_by_four(voxels & 0xFFFFu) | spread_by_four((voxels >> 16) & 0xFFFFu) << 1 |
         spread_by_four((voxels >> 32) & 0xFFFFu) << 2 | spread_by_four(voxels >> 48) << 3;
}

}  // namespace

/// Sets four neighbouring columns at once, as they form one word of 64 bits: the four bits of each column of the cell
/// are moved to the 16 bits of that column, and up to the height at which the cell begins.
void add_cell_to_columns(int cell, std::uint64_t voxels, Columns* columns) {
  const int first = offset_of(cell, 0);
  std::uint16_t* column = &(*columns)[static_cast<std::size_t>(first & 255)];
  const int z = first >> 8;
  std::uint64_t fours = columns_of_cell(voxels);
  for (int y = 0; y < kCellSide; ++y, column += geometry::kBlockSide, fours >>= 16) {
    const std::uint64_t apart =
        (fours & 0xFu) | (fours & 0xF0u) << 12 | (fours & 0xF00u) << 24 | (fours & 0xF000u) << 36;
    std::uint64_t four;
    std::memcpy(&four, column, sizeof four);
    four |= apart << z;
    std::memcpy(column, &four, sizeof four);
  }
}

}  // namespace voxnav::submap
