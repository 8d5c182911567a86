// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/block_update.hpp"

#include <algorithm>

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {
namespace {

/// A quarter of the voxels: more surface does not fit between walls. Bounds the memory of a block.
constexpr std::size_t kMaxLeaves = geometry::kBlockVolume / 4;

VoxelBits hit_bits(const BlockEvidence& evidence) {
  VoxelBits bits{};
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    bits[hit->offset >> 6] |= std::uint64_t{1} << (hit->offset & 63);
  }
  return bits;
}

/// Voxels without hits of their own are missed by any ray that crosses them, the others only by one that went through
/// where the hits were.
std::uint64_t miss_bits(const BlockEvidence& evidence, const SurfaceLeaves& leaves, const VoxelBits& hits, int word) {
  const std::uint64_t through = evidence.through != nullptr ? (*evidence.through)[word] : 0;
  const std::uint64_t passed = evidence.rows != nullptr ? evidence.rows[word].passed & ~leaves.bits()[word] : 0;
  return (passed | through) & ~hits[word];
}

std::size_t count(std::uint64_t word) { return static_cast<std::size_t>(__builtin_popcountll(word)); }

struct Applied {
  BlockUpdate update;
  bool any_level_changed = false;
  bool any_state_changed = false;
};

void apply_misses(OctreeBlock* block, const BlockEvidence& evidence, const VoxelBits& hits, const LogOddsScale& scale,
                  const StateLevels& levels, Applied* out) {
  for (int word = 0; word < 64; ++word) {
    const std::uint64_t misses = miss_bits(evidence, block->leaves, hits, word);
    if (misses == 0) continue;
    out->update.missed += count(misses);
    const Subtracted done = subtract_where(block->log_odds.data() + 64 * word, misses, scale.miss, levels.free_end(),
                                           levels.occupied_begin());
    out->update.became_free += count(done.crossed_free);
    out->any_level_changed = out->any_level_changed || done.any_changed;
    out->any_state_changed = out->any_state_changed || (done.crossed_free | done.crossed_occupied) != 0;
  }
}

void apply_hits(OctreeBlock* block, const BlockEvidence& evidence, const LogOddsScale& scale, const StateLevels& levels,
                Applied* out) {
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    std::uint8_t& level = block->log_odds[hit->offset];
    const auto after = static_cast<std::uint8_t>(std::min<int>(level + scale.hit, scale.max));
    const containers::State state = levels.of(after);
    if (state != levels.of(level)) {
      out->any_state_changed = true;
      out->update.became_occupied += state == containers::State::kOccupied ? 1 : 0;
    }
    out->any_level_changed = out->any_level_changed || after != level;
    level = after;
  }
}

/// New hits get a leaf; a leaf goes when its voxel is free and rays went through where its hits were.
void update_leaves(OctreeBlock* block, const BlockEvidence& evidence, const VoxelBits& hits,
                   const StateLevels& levels) {
  VoxelBits bits = block->leaves.bits();
  std::size_t leaves = 0;
  for (int word = 0; word < 64; ++word) {
    if (evidence.through != nullptr) {
      for_each_bit((*evidence.through)[word] & ~hits[word], [&](int bit) {
        if (block->log_odds[64 * word + bit] < levels.free_end()) bits[word] &= ~(std::uint64_t{1} << bit);
      });
    }
    leaves += count(bits[word] | hits[word]);
    if (leaves <= kMaxLeaves) bits[word] |= hits[word];
  }
  block->leaves.assign(bits);
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    if (SurfaceLeaf* leaf = block->leaves.find(hit->offset)) leaf->add_scan(hit->points);
  }
}

}  // namespace

BlockUpdate update_block(OctreeBlock* block, const BlockEvidence& evidence, const LogOddsScale& scale,
                         const StateLevels& levels) {
  const VoxelBits hits = hit_bits(evidence);
  Applied applied;
  apply_misses(block, evidence, hits, scale, levels, &applied);
  apply_hits(block, evidence, scale, levels, &applied);
  if (evidence.hits_begin != evidence.hits_end || evidence.through != nullptr)
    update_leaves(block, evidence, hits, levels);
  block->changed = block->changed || applied.any_state_changed;
  // Most blocks are free space at the lower clamp, where a miss changes nothing.
  if (applied.any_level_changed || !block->is_summarised()) {
    OctreeBlock::Flags flags;
    block->leaf_flags(levels, &flags);
    block->refresh(flags);
  }
  return applied.update;
}

}  // namespace voxnav::occupancy
