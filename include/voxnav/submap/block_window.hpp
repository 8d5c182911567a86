// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "voxnav/submap/field_block.hpp"

namespace voxnav::submap {

/// Blocks of one content by index; the blocks must outlive it.
class BlockIndex {
 public:
  explicit BlockIndex(const std::vector<FilledBlock>& blocks);
  const FilledBlock* find(const geometry::Index3& index) const;

 private:
  const std::vector<FilledBlock>* blocks_;
  std::unordered_map<geometry::Index3, std::uint32_t, geometry::Index3Hash> position_;
};

/// An occupied leaf seen from a block: voxel coordinates relative to the block's first voxel.
struct WindowLeaf {
  int x, y, z;
  const FilledLeaf* leaf;
  /// Surface point from the centre of the voxel, voxel edges.
  geometry::Vec3f mean() const {
    return geometry::Vec3f(leaf->mean[0], leaf->mean[1], leaf->mean[2]) * (1.0f / 254.0f);
  }
};

/// One block and `halo` voxels around it (halo <= 16).
class BlockWindow {
 public:
  BlockWindow(const BlockIndex& blocks, const geometry::Index3& center, int halo);

  const std::vector<WindowLeaf>& leaves() const { return leaves_; }
  int halo() const { return halo_; }
  int side() const { return geometry::kBlockSide + 2 * halo_; }
  /// Fills states (side^3) from the blocks. Separate, as it is only needed where there are leaves.
  void load_states();
  /// Coordinates relative to the block's first voxel, from -halo to 15 + halo.
  containers::State state(int x, int y, int z) const {
    return static_cast<containers::State>(states_[position(x, y, z)]);
  }
  /// Position in leaves(), or -1.
  int leaf_at(int x, int y, int z) const { return leaf_index_[position(x, y, z)]; }

 private:
  std::size_t position(int x, int y, int z) const {
    return static_cast<std::size_t>(x + halo_ + side() * (y + halo_ + side() * (z + halo_)));
  }
  bool inside(int c) const { return c >= -halo_ && c < geometry::kBlockSide + halo_; }
  void collect(const FilledBlock& block, int dx, int dy, int dz);

  int halo_;
  const FilledBlock* neighbors_[27];
  std::vector<WindowLeaf> leaves_;
  std::vector<std::uint8_t> states_;
  std::vector<std::int32_t> leaf_index_;
};

}  // namespace voxnav::submap
