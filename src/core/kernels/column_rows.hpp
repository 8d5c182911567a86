// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace voxnav::kernels {

constexpr int kBlockSideColumns = 16;

/// Rows of a block, 16 columns of 16 bits each, that are laid into rows of a window of 32-bit columns.
struct ColumnRows {
  const std::uint16_t* from;
  std::uint32_t* to;
  int row_length;  ///< of the window
  int count;       ///< rows
  int up;          ///< voxels that columns are moved by; bits that leave the window are lost
};

/// Adds the voxels that are set.
void add_rows(const ColumnRows& rows);

/// A turned block in a window: where its columns lie, in parts of voxel edges that fit 32 bits (2^shift = one edge).
struct TurnedBlock {
  struct Step {
    std::int32_t x, y;
  };
  Step first;        ///< centre of its first column
  Step right, back;  ///< a step of one voxel of the block along x and along y
  int shift;
  unsigned lowest;  ///< voxel of the window that is the lowest of the block
};

/// block[x + 16 y] |= the column of the window in which the centre of that column of the block lies. The window is made
/// of rows of `row_length` columns, and the block lies inside it.
void add_turned_columns(const std::uint32_t* window, int row_length, const TurnedBlock& at, std::uint16_t* block);

namespace reference {
void add_rows(const ColumnRows& rows);
void add_turned_columns(const std::uint32_t* window, int row_length, const TurnedBlock& at, std::uint16_t* block);
}  // namespace reference

}  // namespace voxnav::kernels
