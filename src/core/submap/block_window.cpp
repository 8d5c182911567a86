// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/block_window.hpp"

#include <algorithm>

namespace voxnav::submap {

using geometry::kBlockSide;

BlockIndex::BlockIndex(const std::vector<FilledBlock>& blocks) : blocks_(&blocks) {
  position_.reserve(blocks.size());
  for (std::size_t i = 0; i < blocks.size(); ++i) position_[blocks[i].index] = static_cast<std::uint32_t>(i);
}

const FilledBlock* BlockIndex::find(const geometry::Index3& index) const {
  const auto it = position_.find(index);
  return it == position_.end() ? nullptr : &(*blocks_)[it->second];
}

BlockWindow::BlockWindow(const BlockIndex& blocks, const geometry::Index3& center, int halo) : halo_(halo) {
  for (int i = 0; i < 27; ++i) {
    const int dx = i % 3 - 1;
    const int dy = i / 3 % 3 - 1;
    const int dz = i / 9 - 1;
    neighbors_[i] = blocks.find(center + geometry::Index3{dx, dy, dz});
    if (neighbors_[i]) collect(*neighbors_[i], dx * kBlockSide, dy * kBlockSide, dz * kBlockSide);
  }
}

void BlockWindow::collect(const FilledBlock& block, int dx, int dy, int dz) {
  for (const FilledLeaf& leaf : block.leaves) {
    const geometry::Index3 local = geometry::voxel_at({0, 0, 0}, leaf.offset);
    const WindowLeaf seen{local.x + dx, local.y + dy, local.z + dz, &leaf};
    if (inside(seen.x) && inside(seen.y) && inside(seen.z)) leaves_.push_back(seen);
  }
}

void BlockWindow::load_states() {
  states_.assign(static_cast<std::size_t>(side()) * side() * side(), 0);
  leaf_index_.assign(states_.size(), -1);
  for (int i = 0; i < 27; ++i) {
    if (!neighbors_[i]) continue;
    const int base[3] = {(i % 3 - 1) * kBlockSide, (i / 3 % 3 - 1) * kBlockSide, (i / 9 - 1) * kBlockSide};
    int first[3];
    int last[3];
    for (int k = 0; k < 3; ++k) {
      first[k] = std::max(base[k], -halo_);
      last[k] = std::min(base[k] + kBlockSide, kBlockSide + halo_);
    }
    for (int z = first[2]; z < last[2]; ++z) {
      for (int y = first[1]; y < last[1]; ++y) {
        std::uint8_t* row = &states_[position(first[0], y, z)];
        const int offset = ((y - base[1]) << 4) | ((z - base[2]) << 8) | (first[0] - base[0]);
        std::uint64_t bits = neighbors_[i]->states.words[static_cast<std::size_t>(offset >> 5)] >> (2 * (offset & 31));
        for (int x = first[0]; x < last[0]; ++x, bits >>= 2) *row++ = static_cast<std::uint8_t>(bits & 3u);
      }
    }
  }
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    leaf_index_[position(leaves_[i].x, leaves_[i].y, leaves_[i].z)] = static_cast<std::int32_t>(i);
  }
}

}  // namespace voxnav::submap
