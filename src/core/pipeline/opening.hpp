// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

namespace voxnav::pipeline {

/// Morphological opening of heights by a square window, in a square of cells amid a margin: the least height in the
/// window around each cell, and then the greatest of those. Cells that are not set take no part.
/// Source: Zhang et al. 2003, section II; both passes by van Herk 1992, A fast algorithm for local minimum and maximum
/// filters on rectangular and octagonal kernels, section 2, which takes three comparisons for each cell.
class Opening {
 public:
  static constexpr std::int32_t kUnknown = INT32_MAX;

  /// @param side    cells of the square
  /// @param margin  cells around it, at least 2 * reach
  /// @param reach   half the width of the window in cells
  Opening(int side, int margin, int reach);

  /// Sets the heights of a row of cells, which may be kUnknown. The place of the first one is counted from the corner
  /// of the square.
  void set_row(int x, int y, const std::int32_t* heights, int count);
  /// Writes the heights of the square, x fastest; kUnknown where nothing is known within the windows.
  void run(std::int32_t* out) const;

 private:
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y) * width_ + static_cast<std::size_t>(x); }

  int side_, margin_, reach_;
  std::size_t width_;
  std::vector<std::int32_t> heights_;
  std::vector<std::uint8_t> is_set_;
};

}  // namespace voxnav::pipeline
