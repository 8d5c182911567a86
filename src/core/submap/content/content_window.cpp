// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/content_window.hpp"

#include <algorithm>

#include "kernels/bits.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

/// Returns the cells of a block that reach into the window; the first voxel of the block is at `first`. Of the 64 bits,
/// a layer of cells at one x has every fourth bit, a layer at one y four consecutive bits of every 16, and a layer at
/// one z 16 consecutive bits.
std::uint64_t cells_within(const Index3& first, int halo) {
  std::uint64_t out = ~std::uint64_t{0};
  const auto keep = [&](int c0, std::uint64_t layer, int step) {
    for (int i = 0; i < kCellSide; ++i) {
      const int c = c0 + i * kCellSide;
      if (c + kCellSide <= -halo || c >= kBlockSide + halo) out &= ~(layer << (step * i));
    }
  };
  keep(first.x, 0x1111111111111111ull, 1);
  keep(first.y, 0x000F000F000F000Full, 4);
  keep(first.z, 0xFFFFull, 16);
  return out;
}

}  // namespace

void ContentWindow::load(const SubmapContent& content, const Index3& block, int halo) {
  content_points_ = &content.points();
  free_.fill(0);
  occupied_.fill(0);
  cells_.clear();
  for (int i = 0; i < 27; ++i) {
    const Index3 step{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    const auto position = content.states().find(block + step);
    if (!position) continue;
    add_block(content.states(), *position, {step.x * kBlockSide, step.y * kBlockSide, step.z * kBlockSide}, halo);
  }
  count_rows();
  for (const OccupiedCell& cell : cells_) take_points(cell);
}

void ContentWindow::add_block(const BlockStates& states, std::size_t position, const Index3& first, int halo) {
  const auto add = [&](int cell, std::uint64_t free, std::uint64_t occupied, std::size_t first_number) {
    const int x = first.x + (cell & 3) * kCellSide;
    const int y = first.y + ((cell >> 2) & 3) * kCellSide;
    const int z = first.z + (cell >> 4) * kCellSide;
    const auto add_rows = [&](std::uint64_t voxels, Rows* rows) {
      for (int row = 0; row < 16; ++row) {
        (*rows)[at(y + (row & 3), z + (row >> 2))] |= static_cast<std::uint32_t>((voxels >> (4 * row)) & 15)
                                                      << (x + kHalo);
      }
    };
    add_rows(free, &free_);
    if (occupied == 0) return;
    add_rows(occupied, &occupied_);
    cells_.push_back({x, y, z, occupied, first_number});
  };
  states.for_each_known_cell(position, cells_within(first, halo), add);
}

void ContentWindow::count_rows() {
  unsigned count = 0;
  for (std::size_t row = 0; row < occupied_.size(); ++row) {
    first_of_row_[row] = static_cast<std::uint16_t>(count);
    if (occupied_[row] != 0) count += kernels::count_bits(occupied_[row]);
  }
  next_of_row_ = first_of_row_;
  voxels_.resize(count);
  numbers_.resize(count);
  points_.resize(count);
}

/// Adds the points of a cell to the rows of the window. Cells are taken by rising x, so each voxel is the next one of
/// its row.
void ContentWindow::take_points(const OccupiedCell& cell) {
  auto number = static_cast<std::uint32_t>(cell.first_number);
  kernels::for_each_bit(cell.voxels, [&](int bit) {
    const int x = cell.x + (bit & 3);
    const int y = cell.y + ((bit >> 2) & 3);
    const int z = cell.z + (bit >> 4);
    const std::size_t i = next_of_row_[at(y, z)]++;
    voxels_[i] = {x, y, z};
    numbers_[i] = number++;
    const geometry::Vec3f p = geometry::Vec3f(x, y, z) + mean(i);
    points_[i] = {p.x(), p.y(), p.z(), 1.0f, p.y(), p.z(), p.x(), 0.0f};
  });
}

std::vector<std::uint16_t> voxels_of_block(const ContentWindow& window) {
  std::vector<std::uint16_t> out;
  for (std::size_t i = 0; i < window.voxels().size(); ++i) {
    const geometry::Index3& voxel = window.voxels()[i];
    // A voxel lies in the block itself if its coordinates fit into four bits.
    if (((voxel.x | voxel.y | voxel.z) & ~15) == 0) out.push_back(static_cast<std::uint16_t>(i));
  }
  return out;
}

}  // namespace voxnav::submap
