// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

namespace voxnav::kernels {

constexpr int kBlockSideColumns = 16;

/// How rows of a block, each with 16 columns of 16 bits, are copied into rows of a window with columns of 32 bits.
struct ColumnRows {
  const std::uint16_t* from;
  std::uint32_t* to;
  int row_length;  ///< columns in a row of the window
  int count;       ///< number of rows
  int up;          ///< voxels by which columns are moved up; bits that leave the window are lost
};

/// ORs the voxels of the block into the window.
void add_rows(const ColumnRows& rows);

/// The columns of a block that is rotated about the vertical relative to a window. Coordinates are fixed-point numbers
/// that fit 32 bits (2^shift = one voxel edge).
struct TurnedBlock {
  struct Step {
    std::int32_t x, y;
  };
  Step first;        ///< centre of the first column of the block
  Step right, back;  ///< step of one voxel of the block along x and along y
  int shift;
  unsigned lowest;  ///< height in the window of the lowest voxels of the block
};

/// ORs into block[x + 16 y] the column of the window in which the centre of that column of the block lies. The window
/// consists of rows of `row_length` columns, and the block lies inside it.
void add_turned_columns(const std::uint32_t* window, int row_length, const TurnedBlock& at, std::uint16_t* block);

namespace reference {
void add_rows(const ColumnRows& rows);
void add_turned_columns(const std::uint32_t* window, int row_length, const TurnedBlock& at, std::uint16_t* block);
}  // namespace reference

}  // namespace voxnav::kernels
