// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "base/bytes.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/submap_config.hpp"

namespace voxnav::test {

/// A submap as versions 2, 3 and 4 of the format wrote it, straight from the content: a code per cell of 4^3 voxels,
/// two bits per voxel, every own leaf.
class OldSubmapBytes {
 public:
  OldSubmapBytes(const occupancy::MapContent& content, std::uint32_t version) : version_(version) {
    for (const occupancy::ContentBlock& block : content.blocks) add_block(block);
  }

  std::string bytes(double resolution_m, const geometry::Pose& T_S_G, const submap::SubmapConfig& config) const {
    base::ByteWriter out;
    out.put<std::uint32_t>(0x4D535856);
    out.put(version_);
    out.put(resolution_m);
    out.put(config.band_voxels);
    out.put(config.max_distance_m);
    out.put<std::int32_t>(config.max_surface_points);
    out.put<std::uint8_t>(config.certified);
    out.put_raw(T_S_G.matrix().data(), 16 * sizeof(double));
    out.put(config.band_voxels);
    put(blocks_, &out);
    put(states_, &out);
    put(near_, &out);
    out.put<std::uint8_t>(0);
    put(leaves_, &out);
    if (version_ >= 3) {
      put(own_, &out);
      out.put_raw(times_.data(), times_.size());
      out.put_raw(own_bits_.data(), own_bits_.size() * sizeof(std::uint64_t));
    }
    if (version_ >= 4) {
      out.put_raw(own_cells_.data(), own_cells_.size() * sizeof(own_cells_[0]));
      put(own_free_, &out);
    }
    out.put<std::uint64_t>(0);  // surface points
    return out.finish();
  }

 private:
  using States = std::array<std::uint64_t, 2>;
  using Leaf = std::array<std::int8_t, 4>;
#pragma pack(push, 1)
  struct Block {
    geometry::Index3 index;
    std::array<std::uint8_t, 64> codes;
  };
#pragma pack(pop)

  template <class T>
  static void put(const std::vector<T>& items, base::ByteWriter* out) {
    out->put<std::uint64_t>(items.size());
    out->put_raw(items.data(), items.size() * sizeof(T));
  }
  static int offset_of(int cell, int voxel) {
    const int x = 4 * (cell & 3) + (voxel & 3);
    const int y = 4 * (cell >> 2 & 3) + (voxel >> 2 & 3);
    return x + 16 * y + 256 * (4 * (cell >> 4) + (voxel >> 4));
  }

  void add_block(const occupancy::ContentBlock& content) {
    Block block{content.index, {}};
    std::array<std::uint64_t, 2> own_cells{};
    int num_states = 0, num_near = 0;
    for (int cell = 0; cell < 64; ++cell) {
      const auto at = static_cast<std::size_t>(cell);
      const std::size_t num_leaves = leaves_.size();
      std::uint64_t free = 0, own = 0;
      const States states = add_cell(content, cell, &free, &own);
      if (leaves_.size() > num_leaves) {
        block.codes[at] = static_cast<std::uint8_t>(66 + num_near++);
        near_.push_back(states);
      } else if (free == ~std::uint64_t{0}) {
        block.codes[at] = 1;
      } else if (free != 0) {
        block.codes[at] = static_cast<std::uint8_t>(2 + num_states++);
        states_.push_back(states);
      }
      if (own != 0) own_cells[own == free ? 0 : 1] |= std::uint64_t{1} << cell;
      if (own != 0 && own != free) own_free_.push_back(own);
    }
    blocks_.push_back(block);
    own_cells_.push_back(own_cells);
  }

  States add_cell(const occupancy::ContentBlock& content, int cell, std::uint64_t* free, std::uint64_t* own) {
    States states{};
    for (int voxel = 0; voxel < 64; ++voxel) {
      const int offset = offset_of(cell, voxel);
      const containers::State state = content.states.get(offset);
      states[static_cast<std::size_t>(voxel / 32)] |= static_cast<std::uint64_t>(state) << (2 * (voxel % 32));
      const std::uint64_t bit = std::uint64_t{1} << voxel;
      if (state == containers::State::kFree) *free |= bit;
      const bool is_own = (content.own_free[static_cast<std::size_t>(offset / 64)] >> (offset % 64)) & 1u;
      if (state == containers::State::kFree && is_own) *own |= bit;
      for (const occupancy::OccupiedLeaf& leaf : content.occupied) {
        if (leaf.offset == offset) add_leaf(leaf);
      }
    }
    return states;
  }

  void add_leaf(const occupancy::OccupiedLeaf& leaf) {
    const std::size_t bit = leaves_.size() % 64;
    if (bit == 0) own_bits_.push_back(0);
    leaves_.push_back({leaf.mean[0], leaf.mean[1], leaf.mean[2], static_cast<std::int8_t>(leaf.hits)});
    if (leaf.own_hits == 0) return;
    own_bits_.back() |= std::uint64_t{1} << bit;
    own_.push_back({leaf.own_mean[0], leaf.own_mean[1], leaf.own_mean[2], static_cast<std::int8_t>(leaf.own_hits)});
    times_.push_back(leaf.own_time);
  }

  std::uint32_t version_;
  std::vector<Block> blocks_;
  std::vector<States> states_, near_;
  std::vector<Leaf> leaves_, own_;
  std::vector<std::uint8_t> times_;
  std::vector<std::uint64_t> own_bits_, own_free_;
  std::vector<std::array<std::uint64_t, 2>> own_cells_;
};

}  // namespace voxnav::test
