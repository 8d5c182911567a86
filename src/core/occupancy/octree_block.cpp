// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/octree_block.hpp"

#include <algorithm>

#include "occupancy/byte_ops.hpp"

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

namespace {

/// Bit i becomes bit 2 i.
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
  static_assert(static_cast<int>(State::kFree) == 1 && static_cast<int>(State::kOccupied) == 2, "a bit each");
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
  return ~bits_at_least(log_odds.data() + 64 * word, levels.free_end());
}

std::uint64_t OctreeBlock::occupied_bits(std::size_t word, const StateLevels& levels) const {
  return bits_at_least(log_odds.data() + 64 * word, levels.occupied_min);
}

ContentBlock OctreeBlock::content(const geometry::Index3& index, const StateLevels& levels, int num_scans) const {
  ContentBlock out;
  out.index = index;
  out.states = states(levels);
  out.occupied.reserve(leaves.size());
  for (std::size_t word = 0; word < seen.size(); ++word) {
    for_each_bit(occupied_bits(word, levels), [&](int bit) {
      const int offset = static_cast<int>(64 * word) + bit;
      const SurfaceLeaf* leaf = leaves.find(offset);
      out.occupied.push_back((leaf ? *leaf : SurfaceLeaf{}).quantised(offset, num_scans));
      // Without hit statistics (their number is bounded) any ray counts as a miss: still occupied means hit.
      if (!leaf && is_seen(offset)) out.occupied.back().own_hits = 1;
    });
  }
  out.own_free = own_free(levels);
  return out;
}

/// A voxel that was hit is not called free, however sure the map was that it is: older scans outvote these hits, and
/// older scans are not the submap's own.
VoxelBits OctreeBlock::own_free(const StateLevels& levels) const {
  VoxelBits out;
  for (std::size_t word = 0; word < out.size(); ++word) {
    out[word] = seen[word] & free_bits(word, levels);
    for_each_bit(out[word] & leaves.bits()[word], [&](int bit) {
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
