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
VoxelBits miss_bits(const BlockEvidence& evidence, const VoxelBits& hits) {
  VoxelBits bits{};
  if (evidence.marks == nullptr) return bits;
  for (int i = 0; i < 64; ++i) {
    const RayMarker::Row& row = evidence.marks->rows[i];
    bits[i] = ((row.passed & ~row.surface) | (evidence.through ? (*evidence.through)[i] : 0)) & ~hits[i];
  }
  return bits;
}

void apply(OctreeBlock* block, const VoxelBits& misses, const BlockEvidence& evidence, const LogOddsScale& scale) {
  for (int i = 0; i < 64; ++i) {
    if (misses[i] != 0) subtract_where(block->log_odds.data() + 64 * i, misses[i], scale.miss);
  }
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    std::uint8_t& level = block->log_odds[hit->offset];
    level = static_cast<std::uint8_t>(std::min<int>(level + scale.hit, scale.max));
  }
}

/// New hits get a leaf; a leaf goes when its voxel is free and rays went through where its hits were.
void update_leaves(OctreeBlock* block, const BlockEvidence& evidence, const VoxelBits& hits,
                   const OctreeBlock::Flags& flags) {
  VoxelBits bits = block->leaves.bits();
  std::size_t count = 0;
  for (int i = 0; i < 64; ++i) {
    if (evidence.through != nullptr) {
      for_each_bit((*evidence.through)[i] & ~hits[i], [&](int bit) {
        if (flags[64 * i + bit] == kContainsFree) bits[i] &= ~(std::uint64_t{1} << bit);
      });
    }
    const std::uint64_t with_new = bits[i] | hits[i];
    count += static_cast<std::size_t>(__builtin_popcountll(with_new));
    if (count <= kMaxLeaves) bits[i] = with_new;
  }
  block->leaves.assign(bits);
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    if (SurfaceLeaf* leaf = block->leaves.find(hit->offset)) leaf->add_scan(hit->mean);
  }
}

std::size_t count_new(const OctreeBlock::Flags& before, const OctreeBlock::Flags& after, std::uint8_t flag) {
  std::size_t count = 0;
  for (int i = 0; i < geometry::kBlockVolume; ++i) count += after[i] == flag && before[i] != flag ? 1 : 0;
  return count;
}

}  // namespace

BlockUpdate update_block(OctreeBlock* block, const BlockEvidence& evidence, const LogOddsScale& scale,
                         const StateLevels& levels) {
  BlockUpdate out;
  const VoxelBits hits = hit_bits(evidence);
  const VoxelBits misses = miss_bits(evidence, hits);
  for (const std::uint64_t word : misses) out.missed += static_cast<std::size_t>(__builtin_popcountll(word));
  OctreeBlock::Flags before;
  OctreeBlock::Flags after;
  block->leaf_flags(levels, &before);
  apply(block, misses, evidence, scale);
  block->leaf_flags(levels, &after);
  update_leaves(block, evidence, hits, after);
  if (before != after) {
    out.became_free = count_new(before, after, kContainsFree);
    out.became_occupied = count_new(before, after, kContainsOccupied);
    block->changed = true;
  }
  block->refresh(after);
  return out;
}

}  // namespace voxnav::occupancy
