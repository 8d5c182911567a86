// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/block_update.hpp"

#include <algorithm>
#include <cstddef>

#include "kernels/masked_bytes.hpp"

namespace voxnav::occupancy {
namespace {

using kernels::count_bits;
using kernels::for_each_bit;

/// A block keeps hit statistics for at most a quarter of its voxels, which bounds its memory. Surfaces of real scenes
/// occupy a smaller share of the voxels than that.
constexpr std::size_t kMaxLeaves = geometry::kBlockVolume / 4;

/// Finds the voxels with hits of earlier scans whose surface this scan saw through.
VoxelBits refuted_bits(OctreeBlock* block, const BlockEvidence& evidence, const VoxelBits& hits,
                       const SurfaceSight& sight) {
  if (block->leaves.empty()) return {};
  VoxelBits asked;
  for (std::size_t word = 0; word < asked.size(); ++word) {
    asked[word] = evidence.passed[word] & block->leaves.bits()[word] & ~hits[word];
  }
  return sight.refuted(evidence.first_voxel, asked, &block->leaves);
}

/// Tells whether one of the 26 neighbours of a voxel is above a level, as far as they lie in the same block.
bool is_beside(const std::uint8_t* levels, int offset, std::uint8_t above) {
  const int x = offset & 15, y = (offset >> 4) & 15, z = offset >> 8;
  for (int nz = std::max(z - 1, 0); nz <= std::min(z + 1, 15); ++nz) {
    for (int ny = std::max(y - 1, 0); ny <= std::min(y + 1, 15); ++ny) {
      const std::uint8_t* row = levels + std::ptrdiff_t{16} * (16 * nz + ny);
      for (int nx = std::max(x - 1, 0); nx <= std::min(x + 1, 15); ++nx) {
        if (row[nx] > above) return true;
      }
    }
  }
  return false;
}

bool is_set(const VoxelBits* bits, int offset) {
  return bits != nullptr && (((*bits)[static_cast<std::size_t>(offset) >> 6] >> (offset & 63)) & 1u) != 0;
}

struct Applied {
  BlockUpdate update;
  bool any_level_changed = false;
};

/// Counts misses. A voxel without hits of earlier scans is missed by any ray that crosses it, a voxel with hits only
/// when it is refuted.
void apply_misses(OctreeBlock* block, const BlockEvidence& evidence, const VoxelBits& hits, const VoxelBits& refuted,
                  const LogOddsScale& scale, const StateLevels& levels, Applied* out) {
  VoxelBits misses;
  for (std::size_t word = 0; word < misses.size(); ++word) {
    const std::uint64_t spared = hits[word] | (block->leaves.bits()[word] & ~refuted[word]);
    misses[word] = evidence.passed[word] & ~spared;
  }
  const kernels::Subtraction by{scale.miss, levels.free_end(), levels.occupied_begin()};
  const kernels::SubtractedBlock done = kernels::subtract_in_block(block->log_odds.data(), misses.data(), by);
  out->update.missed += done.num_asked;
  out->update.became_free += done.crossed_free;
  out->any_level_changed = out->any_level_changed || done.any_changed;
  out->update.any_state_changed = out->update.any_state_changed || done.crossed_free + done.crossed_occupied != 0;
}

/// Counts hits. A hit in a voxel that is believed free outweighs the misses before it if the map believes in surface
/// right beside: beams that pass a leaf or an edge in its voxel say nothing against it. Far from any surface it is more
/// likely a drop of rain, and counts as one hit.
void apply_hits(OctreeBlock* block, const BlockEvidence& evidence, const LogOddsScale& scale, const StateLevels& levels,
                Applied* out) {
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    if (is_set(evidence.body_bits, hit->offset)) continue;
    std::uint8_t& level = block->log_odds[hit->offset];
    const bool is_surface = level < scale.prior && is_beside(block->log_odds.data(), hit->offset, scale.prior);
    const auto after =
        static_cast<std::uint8_t>(std::min<int>((is_surface ? scale.prior : level) + scale.hit, scale.max));
    const containers::VoxelState state = levels.of(after);
    if (state != levels.of(level)) {
      out->update.any_state_changed = true;
      out->update.became_occupied += state == containers::VoxelState::kOccupied ? 1 : 0;
    }
    out->any_level_changed = out->any_level_changed || after != level;
    level = after;
  }
}

/// Gives voxels with new hits a leaf, and takes the leaf from a voxel that is free and was refuted.
void update_leaves(OctreeBlock* block, const BlockEvidence& evidence, const VoxelBits& hits, const VoxelBits& refuted,
                   const StateLevels& levels) {
  VoxelBits bits = block->leaves.bits();
  std::size_t leaves = 0;
  for (int word = 0; word < 64; ++word) {
    const std::uint64_t in_bodies = evidence.body_bits != nullptr ? (*evidence.body_bits)[word] : 0;
    const std::uint64_t believed = hits[word] & ~in_bodies;
    for_each_bit(refuted[word], [&](int bit) {
      if (block->log_odds[64 * word + bit] < levels.free_end()) bits[word] &= ~(std::uint64_t{1} << bit);
    });
    leaves += count_bits(bits[word] | believed);
    if (leaves <= kMaxLeaves) bits[word] |= believed;
  }
  block->leaves.assign(bits);
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    if (is_set(evidence.body_bits, hit->offset)) continue;
    if (SurfaceLeaf* leaf = block->leaves.find(hit->offset)) leaf->add_scan(hit->points, evidence.scan_number);
  }
}

/// Lists the hits in new voxels. Both the hits of a block and its new voxels are sorted by offset.
void report_hits_of_new(const OctreeBlock& block, const BlockEvidence& evidence, const StateLevels& levels,
                        std::vector<HitOfNew>* out) {
  const HitVoxel* hit = evidence.hits_begin;
  for (const NewVoxel& voxel : block.new_voxels.all()) {
    if (voxel.last_scan != evidence.scan) continue;
    while (hit->offset != voxel.offset) ++hit;
    const bool is_first = voxel.first_scan == evidence.scan;
    out->push_back({hit, is_first, voxel.is_clear, levels.of(block.log_odds[voxel.offset])});
  }
}

}  // namespace

BlockUpdate update_block(OctreeBlock* block, const BlockEvidence& evidence, const UpdateRules& rules,
                         std::vector<HitOfNew>* hits_of_new) {
  static const VoxelBits kNone{};
  const StateLevels& levels = rules.levels;
  const VoxelBits& hits = evidence.hit_bits != nullptr ? *evidence.hit_bits : kNone;
  const VoxelBits refuted = refuted_bits(block, evidence, hits, rules.sight);
  Applied applied;
  apply_misses(block, evidence, hits, refuted, rules.scale, levels, &applied);
  NewVoxels& new_voxels = block->new_voxels;
  applied.update.new_not_kept =
      new_voxels.add_hits(evidence.hits_begin, evidence.hits_end, block->log_odds.data(), levels, evidence.scan);
  apply_hits(block, evidence, rules.scale, levels, &applied);
  if (!new_voxels.empty()) {
    report_hits_of_new(*block, evidence, levels, hits_of_new);
    new_voxels.end_scan(refuted, evidence.scan);
  }
  const VoxelBits& in_bodies = evidence.body_bits != nullptr ? *evidence.body_bits : kNone;
  for (int word = 0; word < 64; ++word) {
    block->seen[word] |= (evidence.passed[word] | hits[word]) & ~in_bodies[word];
  }
  if (evidence.hit_bits != nullptr || refuted != kNone) update_leaves(block, evidence, hits, refuted, levels);
  // Inner nodes need no work where no level changed: most blocks are free space at the lower clamp, where a miss
  // changes nothing.
  if (applied.any_level_changed || !block->is_summarised()) {
    OctreeBlock::Flags flags;
    block->leaf_flags(levels, &flags);
    block->refresh(flags);
  }
  return applied.update;
}

}  // namespace voxnav::occupancy
