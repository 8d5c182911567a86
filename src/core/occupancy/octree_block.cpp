// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/octree_block.hpp"

#include <algorithm>

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {
namespace {

using containers::State;

struct Max {
  VOXNAV_INLINE std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const { return a > b ? a : b; }
};
struct Or {
  VOXNAV_INLINE std::uint8_t operator()(std::uint8_t a, std::uint8_t b) const {
    return static_cast<std::uint8_t>(a | b);
  }
};

/// Eight children to one parent over a whole level of Side^3 nodes. Rows are combined first, so that the
/// compiler turns the inner loop into vector instructions.
template <int Side, class Combine>
VOXNAV_INLINE void reduce(const std::uint8_t* in, std::uint8_t* out, Combine combine) {
  constexpr int kHalf = Side / 2;
  for (int z = 0; z < kHalf; ++z) {
    for (int y = 0; y < kHalf; ++y) {
      const std::uint8_t* row = in + (2 * z * Side + 2 * y) * Side;
      std::uint8_t merged[Side];
      for (int x = 0; x < Side; ++x) {
        merged[x] = combine(combine(row[x], row[x + Side]), combine(row[x + Side * Side], row[x + Side * Side + Side]));
      }
      for (int x = 0; x < kHalf; ++x) out[(z * kHalf + y) * kHalf + x] = combine(merged[2 * x], merged[2 * x + 1]);
    }
  }
}

template <class Combine>
VOXNAV_INLINE void reduce_all(const std::uint8_t* voxels, std::uint8_t* nodes, Combine combine) {
  reduce<16>(voxels, nodes, combine);
  reduce<8>(nodes, nodes + 512, combine);
  reduce<4>(nodes + 512, nodes + 576, combine);
  reduce<2>(nodes + 576, nodes + 584, combine);
}

}  // namespace

constexpr std::array<int, OctreeBlock::kLevels + 1> OctreeBlock::kFirst;

namespace {

VOXNAV_INLINE void find_flags(const OctreeBlock& block, const StateLevels& levels, OctreeBlock::Flags* flags) {
  const std::uint8_t free_end = levels.free_end();
  const std::uint8_t occupied_min = levels.occupied_begin();
  for (int i = 0; i < geometry::kBlockVolume; ++i) {
    const std::uint8_t level = block.log_odds[i];
    const std::uint8_t not_free = level >= occupied_min ? kContainsOccupied : kContainsUnknown;
    (*flags)[i] = level < free_end ? static_cast<std::uint8_t>(kContainsFree) : not_free;
  }
}
VOXNAV_WIDE void find_flags_wide(const OctreeBlock& block, const StateLevels& levels, OctreeBlock::Flags* flags) {
  find_flags(block, levels, flags);
}

/// All inner nodes.
VOXNAV_INLINE void summarise(const std::uint8_t* log_odds, const std::uint8_t* flags, std::uint8_t* max,
                             std::uint8_t* inner_flags) {
  reduce_all(log_odds, max, Max{});
  reduce_all(flags, inner_flags, Or{});
}
VOXNAV_WIDE void summarise_wide(const std::uint8_t* log_odds, const std::uint8_t* flags, std::uint8_t* max,
                                std::uint8_t* inner_flags) {
  summarise(log_odds, flags, max, inner_flags);
}

}  // namespace

void OctreeBlock::leaf_flags(const StateLevels& levels, Flags* flags) const {
  (base::is_wide() ? find_flags_wide : find_flags)(*this, levels, flags);
}

void OctreeBlock::refresh(const Flags& flags) {
  (base::is_wide() ? summarise_wide : summarise)(log_odds.data(), flags.data(), max_.data(), flags_.data());
}

containers::StateBlock OctreeBlock::states(const StateLevels& levels) const {
  Flags flags;
  leaf_flags(levels, &flags);
  containers::StateBlock out;
  // Unknown 1, free 2, occupied 4 become 0, 1, 2 by halving.
  for (int word = 0; word < geometry::kBlockVolume / 32; ++word) {
    std::uint64_t packed = 0;
    for (int i = 0; i < 32; ++i) packed |= static_cast<std::uint64_t>(flags[word * 32 + i] >> 1) << (2 * i);
    out.words[word] = packed;
  }
  return out;
}

ContentBlock OctreeBlock::content(const geometry::Index3& index, const StateLevels& levels, int num_scans) const {
  ContentBlock out;
  out.index = index;
  out.states = states(levels);
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    if (log_odds[offset] < levels.occupied_min) continue;
    const SurfaceLeaf* leaf = leaves.find(offset);
    out.occupied.push_back((leaf ? *leaf : SurfaceLeaf{}).quantised(offset, num_scans));
    // Without hit statistics (their number is bounded) any ray counts as a miss: still occupied means hit.
    if (!leaf && is_seen(offset)) out.occupied.back().own_hits = 1;
  }
  out.own_free = own_free(levels);
  return out;
}

/// A voxel that was hit is not called free, however sure the map was that it is: older scans outvote these hits, and
/// older scans are not the submap's own.
VoxelBits OctreeBlock::own_free(const StateLevels& levels) const {
  VoxelBits out = seen;
  const std::uint8_t free_end = levels.free_end();
  for (int word = 0; word < 64; ++word) {
    if (seen[word] == 0) continue;
    std::uint64_t free = 0;
    for (int bit = 0; bit < 64; ++bit) {
      free |= static_cast<std::uint64_t>(log_odds[64 * word + bit] < free_end ? 1 : 0) << bit;
    }
    for_each_bit(seen[word] & free & leaves.bits()[word], [&](int bit) {
      if (leaves.find(64 * word + bit)->recent_scans > 0) free &= ~(std::uint64_t{1} << bit);
    });
    out[word] &= free;
  }
  return out;
}

void OctreeBlock::begin_handover() {
  seen = {};
  leaves.begin_handover();
}

}  // namespace voxnav::occupancy
