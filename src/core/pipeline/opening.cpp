// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/opening.hpp"

#include <algorithm>
#include <stdexcept>

namespace voxnav::pipeline {
namespace {

using Cells = std::vector<std::int32_t>;

/// Writes the better one of each pair of two rows. The loop is over whole rows, because compilers turn that into vector
/// instructions.
template <class Better>
void better_rows(const std::int32_t* a, const std::int32_t* b, std::size_t width, Better better, std::int32_t* out) {
  for (std::size_t x = 0; x < width; ++x) out[x] = better(a[x], b[x]);
}

/// Replaces each row of a square by the best of those in the window around it. Rows nearer to an end than reach are
/// left as they are.
template <class Better>
void slide_down(Cells* cells, std::size_t width, std::size_t reach, Better better) {
  const std::size_t window = 2 * reach + 1;
  // The best from the beginning of each piece as long as the window, and the best up to its end.
  Cells before = *cells, after = *cells;
  for (std::size_t y = 1; y < width; ++y) {
    std::int32_t* row = &before[y * width];
    if (y % window != 0) better_rows(row - width, row, width, better, row);
  }
  for (std::size_t y = width - 1; y-- > 0;) {
    std::int32_t* row = &after[y * width];
    if ((y + 1) % window != 0) better_rows(row, row + width, width, better, row);
  }
  for (std::size_t y = reach; y + reach < width; ++y) {
    better_rows(&after[(y - reach) * width], &before[(y + reach) * width], width, better, &(*cells)[y * width]);
  }
}

void transpose(Cells* cells, std::size_t width) {
  for (std::size_t y = 0; y < width; ++y) {
    for (std::size_t x = 0; x < y; ++x) std::swap((*cells)[y * width + x], (*cells)[x * width + y]);
  }
}

template <class Better>
void slide(Cells* cells, std::size_t width, int reach, Better better) {
  for (int axis = 0; axis < 2; ++axis) {
    slide_down(cells, width, static_cast<std::size_t>(reach), better);
    transpose(cells, width);
  }
}

}  // namespace

Opening::Opening(int side, int margin, int reach)
    : side_(side), margin_(margin), reach_(reach), width_(static_cast<std::size_t>(side + 2 * margin)) {
  if (side < 1 || reach < 0 || margin < 2 * reach) throw std::invalid_argument("opening: the margin is too small");
  heights_.assign(width_ * width_, kUnknown);
  is_set_.assign(width_ * width_, 0);
}

void Opening::set_row(int x, int y, const std::int32_t* heights, int count) {
  const std::size_t first = at(x + margin_, y + margin_);
  std::copy(heights, heights + count, heights_.begin() + static_cast<std::ptrdiff_t>(first));
  std::fill_n(is_set_.begin() + static_cast<std::ptrdiff_t>(first), count, std::uint8_t{1});
}

void Opening::run(std::int32_t* out) const {
  std::vector<std::int32_t> cells = heights_;
  slide(&cells, width_, reach_, [](std::int32_t a, std::int32_t b) { return std::min(a, b); });
  for (std::size_t i = 0; i < cells.size(); ++i) {
    if (is_set_[i] == 0 || cells[i] == kUnknown) cells[i] = INT32_MIN;
  }
  slide(&cells, width_, reach_, [](std::int32_t a, std::int32_t b) { return std::max(a, b); });
  for (int y = 0; y < side_; ++y) {
    for (int x = 0; x < side_; ++x) {
      const std::int32_t height = cells[at(x + margin_, y + margin_)];
      out[y * side_ + x] = height == INT32_MIN ? kUnknown : height;
    }
  }
}

}  // namespace voxnav::pipeline
