// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/field_window.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

constexpr int kCellSide = 4;

/// Even bits of the four layers of a cell at one column: bits xy, xy + 32 of both words.
unsigned column_of(const std::array<std::uint64_t, 2>& states, int bit) {
  const std::uint64_t low = states[0] >> bit;
  const std::uint64_t high = states[1] >> bit;
  return static_cast<unsigned>((low & 1) | ((low >> 31) & 2) | ((high & 1) << 2) | ((high >> 29) & 8));
}

}  // namespace

void FieldWindow::load(const CompressedField& field, const Index3& block, int halo) {
  free_.fill(0);
  occupied_.fill(0);
  leaves_.clear();
  for (int i = 0; i < 27; ++i) {
    const Index3 step{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
    const int position = field.position_of(block + step);
    if (position < 0) continue;
    add_block(field, position, {step.x * kBlockSide, step.y * kBlockSide, step.z * kBlockSide}, halo);
  }
}

void FieldWindow::add_block(const CompressedField& field, int position, const Index3& first, int halo) {
  const auto is_in = [&](int c) { return c + kCellSide > -halo && c < kBlockSide + halo; };
  field.for_each_cell(position, [&](int cell, const auto& states, const CompressedField::Leaf* leaf) {
    const int x0 = first.x + (cell & 3) * kCellSide;
    const int y0 = first.y + ((cell >> 2) & 3) * kCellSide;
    const int z0 = first.z + (cell >> 4) * kCellSide;
    if (!is_in(x0) || !is_in(y0) || !is_in(z0)) return;
    constexpr std::uint64_t kAllFree = 0x5555555555555555ull;
    const bool is_free = states[0] == kAllFree && states[1] == kAllFree;
    for (int xy = 0; xy < 16; ++xy) {
      const std::size_t column = at(x0 + (xy & 3), y0 + (xy >> 2));
      const unsigned free = is_free ? 15u : column_of(states, 2 * xy);
      free_[column] |= free << (z0 + kHalo);
      if (leaf) occupied_[column] |= column_of(states, 2 * xy + 1) << (z0 + kHalo);
    }
    for (int word = 0; leaf && word < 2; ++word) {
      for (std::uint64_t bits = states[word] & ~kAllFree; bits != 0; bits &= bits - 1, ++leaf) {
        const int voxel = 32 * word + (__builtin_ctzll(bits) >> 1);
        const int x = x0 + (voxel & 3);
        const int y = y0 + ((voxel >> 2) & 3);
        const int z = z0 + (voxel >> 4);
        leaf_index_[at(x, y) * kSide + static_cast<std::size_t>(z + kHalo)] =
            static_cast<std::uint16_t>(leaves_.size());
        const geometry::Vec3f mean(leaf->mean[0], leaf->mean[1], leaf->mean[2]);
        leaves_.push_back({x, y, z, mean * (1.0f / 254.0f), leaf->hits, field.phase_of(leaf)});
      }
    }
  });
}

}  // namespace voxnav::submap
