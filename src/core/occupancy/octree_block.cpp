// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/octree_block.hpp"

#include <algorithm>

#include "kernels/bits.hpp"
#include "kernels/masked_bytes.hpp"
#include "kernels/octree_levels.hpp"

namespace voxnav::occupancy {

using containers::VoxelState;

void OctreeBlock::leaf_flags(const StateLevels& levels, Flags* flags) const {
  const kernels::LevelFlags by{levels.free_end(), levels.occupied_begin(), kContainsFree, kContainsUnknown,
                               kContainsOccupied};
  kernels::flags_of_levels(log_odds.data(), by, flags->data());
}

void OctreeBlock::refresh(const Flags& flags) {
  kernels::summarise_levels(log_odds.data(), flags.data(), max_.data(), flags_.data());
}

namespace {

/// Spreads bits apart: bit i of the argument becomes bit 2 i of the result.
std::uint64_t spread_out(std::uint32_t bits) {
  std::uint64_t out = bits;
  out = (out | (out << 16)) & 0x0000FFFF0000FFFFu;
  out = (out | (out << 8)) & 0x00FF00FF00FF00FFu;
  out = (out | (out << 4)) & 0x0F0F0F0F0F0F0F0Fu;
  out = (out | (out << 2)) & 0x3333333333333333u;
  return (out | (out << 1)) & 0x5555555555555555u;
}

}  // namespace

containers::StateBlock OctreeBlock::states(const StateLevels& levels) const {
  static_assert(static_cast<int>(VoxelState::kFree) == 1 && static_cast<int>(VoxelState::kOccupied) == 2, "a bit each");
  containers::StateBlock out;
  for (std::size_t word = 0; word < out.words.size() / 2; ++word) {
    const std::uint64_t free = free_bits(word, levels), occupied = occupied_bits(word, levels);
    for (std::size_t half = 0; half < 2; ++half) {
      const auto part = [half](std::uint64_t bits) {
        return spread_out(static_cast<std::uint32_t>(bits >> (32 * half)));
      };
      out.words[2 * word + half] = part(free) | part(occupied) << 1;
    }
  }
  return out;
}

std::uint64_t OctreeBlock::free_bits(std::size_t word, const StateLevels& levels) const {
  return ~kernels::bits_at_least(log_odds.data() + 64 * word, levels.free_end());
}

std::uint64_t OctreeBlock::occupied_bits(std::size_t word, const StateLevels& levels) const {
  return kernels::bits_at_least(log_odds.data() + 64 * word, levels.occupied_min);
}

ContentBlock OctreeBlock::content(const geometry::Index3& index, const StateLevels& levels, int num_scans) const {
  ContentBlock out;
  out.index = index;
  out.states = states(levels);
  out.occupied.reserve(leaves.size());
  for (std::size_t word = 0; word < seen.size(); ++word) {
    kernels::for_each_bit(occupied_bits(word, levels), [&](int bit) {
      const int offset = static_cast<int>(64 * word) + bit;
      const SurfaceLeaf* leaf = leaves.find(offset);
      out.occupied.push_back((leaf ? *leaf : SurfaceLeaf{}).quantised(offset, num_scans));
      // The number of voxels with hit statistics is bounded. In an occupied voxel beyond that bound every ray that
      // crosses it counts as a miss, so a voxel that was seen and is still occupied must have been hit.
      if (!leaf && is_seen(offset)) out.occupied.back().observed.hits = 1;
    });
  }
  out.observed_free = observed_free(levels);
  leave_out_moving(levels, &out);
  return out;
}

/// Gives voxels in which something moves the state that they had before. Whether they are free now was not observed.
void OctreeBlock::leave_out_moving(const StateLevels& levels, ContentBlock* content) const {
  for (const NewVoxel& voxel : new_voxels.all()) {
    if (!voxel.is_moving) continue;
    content->states.set(voxel.offset, levels.of(voxel.level_before));
    content->observed_free[voxel.offset >> 6] &= ~(std::uint64_t{1} << (voxel.offset & 63));
    const auto is_it = [&](const OccupiedVoxel& occupied) { return occupied.offset == voxel.offset; };
    auto& occupied = content->occupied;
    occupied.erase(std::remove_if(occupied.begin(), occupied.end(), is_it), occupied.end());
  }
}

/// Excludes voxels that were hit since the last handover even if the map holds them for free: there the misses of older
/// scans outvote the hits, and the misses of older scans are not observations of this submap.
VoxelBits OctreeBlock::observed_free(const StateLevels& levels) const {
  VoxelBits out;
  for (std::size_t word = 0; word < out.size(); ++word) {
    out[word] = seen[word] & free_bits(word, levels);
    kernels::for_each_bit(out[word] & leaves.bits()[word], [&](int bit) {
      if (leaves.find(static_cast<int>(64 * word) + bit)->recent_scans > 0) out[word] &= ~(std::uint64_t{1} << bit);
    });
  }
  return out;
}

void OctreeBlock::begin_handover() {
  seen = {};
  leaves.begin_handover();
}

}  // namespace voxnav::occupancy
