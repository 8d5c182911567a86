// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/evidence_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

geometry::Aabb block_box(const Index3& block, double side_m) {
  return {Vec3(block.x, block.y, block.z) * side_m, Vec3(block.x + 1, block.y + 1, block.z + 1) * side_m};
}

}  // namespace

EvidenceMap::EvidenceMap(double resolution_m, double clearing_distance_m)
    : resolution_m_(resolution_m), clearing_distance_m_(clearing_distance_m) {
  if (!(resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
}

void EvidenceMap::integrate(const Index3& index, const PlacedSubmap& submap) {
  EvidenceBlock& block = blocks_[index];
  drop_cleared(index, submap, &block);
  submap.add_free(index, &block.states.free);
  take_leaves(submap.leaves(index), &block);
  block.states.occupied.fill(0);
  for (const EvidenceLeaf& leaf : block.leaves) {
    block.states.occupied[leaf.offset & 255u] |= static_cast<std::uint16_t>(1u << (leaf.offset >> 8));
  }
  // Under a leaf nothing is free, also not once a newer submap has taken the leaf away: that submap has to say so.
  for (std::size_t i = 0; i < block.states.free.size(); ++i) block.states.free[i] &= ~block.states.occupied[i];
  if (block.leaves.empty() && block.states.all_unknown()) blocks_.erase(index);
}

void EvidenceMap::drop_cleared(const Index3& index, const PlacedSubmap& submap, EvidenceBlock* block) const {
  const auto is_gone = [&](const EvidenceLeaf& leaf) {
    return submap.clears(point_of(index, leaf), clearing_distance_m_);
  };
  block->leaves.erase(std::remove_if(block->leaves.begin(), block->leaves.end(), is_gone), block->leaves.end());
}

/// Newer points replace the older ones of their voxel.
void EvidenceMap::take_leaves(const PlacedSubmap::Range& leaves, EvidenceBlock* block) const {
  if (leaves.first == leaves.last) return;
  Columns seen{};
  for (const EvidenceLeaf& leaf : leaves)
    seen[leaf.offset & 255u] |= static_cast<std::uint16_t>(1u << (leaf.offset >> 8));
  const auto is_replaced = [&](const EvidenceLeaf& leaf) {
    return (seen[leaf.offset & 255u] >> (leaf.offset >> 8)) & 1;
  };
  block->leaves.erase(std::remove_if(block->leaves.begin(), block->leaves.end(), is_replaced), block->leaves.end());
  block->leaves.insert(block->leaves.end(), leaves.begin(), leaves.end());
}

const EvidenceBlock* EvidenceMap::find(const Index3& block) const {
  const auto it = blocks_.find(block);
  return it == blocks_.end() ? nullptr : &it->second;
}

State EvidenceMap::state(const Vec3& p_W) const {
  if (!((p_W.array().abs() / resolution_m_) < 1073741824.0).all()) return State::kUnknown;
  const Index3 voxel = geometry::index_of(p_W, resolution_m_);
  const EvidenceBlock* block = find(geometry::block_of(voxel));
  return block ? block->states.get(geometry::offset_in_block(voxel)) : State::kUnknown;
}

Vec3 EvidenceMap::point_of(const Index3& block, const EvidenceLeaf& leaf) const {
  const Vec3 mean(leaf.mean[0], leaf.mean[1], leaf.mean[2]);
  return geometry::center_of(geometry::voxel_at(block, leaf.offset), resolution_m_) + mean * (resolution_m_ / 254.0);
}

std::optional<double> EvidenceMap::distance_to_surface(const Vec3& p_W, double max_distance_m) const {
  const double side_m = kBlockSide * resolution_m_;
  double best = max_distance_m * max_distance_m;
  bool found = false;
  const Index3 low = geometry::index_of(p_W - Vec3::Constant(max_distance_m), side_m);
  const Index3 high = geometry::index_of(p_W + Vec3::Constant(max_distance_m), side_m);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const geometry::Aabb box = block_box({x, y, z}, side_m);
        if ((p_W - p_W.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm() >= best) continue;
        const EvidenceBlock* block = find({x, y, z});
        if (!block) continue;
        for (const EvidenceLeaf& leaf : block->leaves) {
          const double squared = (p_W - point_of({x, y, z}, leaf)).squaredNorm();
          if (squared >= best) continue;
          best = squared;
          found = true;
        }
      }
    }
  }
  if (!found) return std::nullopt;
  return std::sqrt(best);
}

std::size_t EvidenceMap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.bucket_count() * sizeof(void*);
  for (const auto& entry : blocks_) {
    bytes += sizeof(entry) + 2 * sizeof(void*) + entry.second.leaves.capacity() * sizeof(EvidenceLeaf);
  }
  return bytes;
}

}  // namespace voxnav::submap
