// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/field_window.hpp"

#include <algorithm>

#include "kernels/bits.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

constexpr int kCellSide = 4;

/// Cells of a block that reach into the window; its first voxel is at `first`.
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

void FieldWindow::load(const CompressedField& field, const Index3& block, int halo) {
  free_.fill(0);
  occupied_.fill(0);
  cells_.clear();
  for (int i = 0; i < 27; ++i) {
    const Index3 step{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    const int position = field.position_of(block + step);
    if (position < 0) continue;
    add_block(field, position, {step.x * kBlockSide, step.y * kBlockSide, step.z * kBlockSide}, halo);
  }
  number_leaves();
  for (const OccupiedCell& cell : cells_) take_leaves(field, cell);
}

void FieldWindow::add_block(const CompressedField& field, int position, const Index3& first, int halo) {
  const auto add = [&](int cell, std::uint64_t free, std::uint64_t occupied, const CompressedField::Leaf* leaves) {
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
    if (!leaves) return;
    add_rows(occupied, &occupied_);
    cells_.push_back({x, y, z, occupied, leaves});
  };
  field.for_each_cell(position, cells_within(first, halo), add);
}

void FieldWindow::number_leaves() {
  unsigned count = 0;
  for (std::size_t row = 0; row < occupied_.size(); ++row) {
    first_leaf_[row] = static_cast<std::uint16_t>(count);
    if (occupied_[row] != 0) count += kernels::count_bits(occupied_[row]);
  }
  next_leaf_ = first_leaf_;
  leaves_.resize(count);
  points_.resize(count);
}

/// Cells come by rising x, so each leaf is the next one of its row.
void FieldWindow::take_leaves(const CompressedField& field, const OccupiedCell& cell) {
  const CompressedField::Leaf* leaf = cell.leaves;
  for (std::uint64_t bits = cell.voxels; bits != 0; bits &= bits - 1, ++leaf) {
    const int bit = __builtin_ctzll(bits);
    const int x = cell.x + (bit & 3);
    const int y = cell.y + ((bit >> 2) & 3);
    const int z = cell.z + (bit >> 4);
    const std::size_t i = next_leaf_[at(y, z)]++;
    leaves_[i] = {static_cast<std::int16_t>(x), static_cast<std::int16_t>(y), static_cast<std::int16_t>(z), *leaf,
                  field.phase_of(leaf)};
    const geometry::Vec3f p = geometry::Vec3f(x, y, z) + leaves_[i].mean();
    points_[i] = {p.x(), p.y(), p.z(), 1.0f, p.y(), p.z(), p.x(), 0.0f};
  }
}

std::vector<std::uint16_t> leaves_of_block(const FieldWindow& window) {
  std::vector<std::uint16_t> out;
  for (std::size_t k = 0; k < window.leaves().size(); ++k) {
    const WindowLeaf& leaf = window.leaves()[k];
    if (((leaf.x | leaf.y | leaf.z) & ~15) == 0) out.push_back(static_cast<std::uint16_t>(k));
  }
  return out;
}

}  // namespace voxnav::submap
