// SPDX-License-Identifier: BSD-3-Clause
#include "planning/clearance/clearance_blocks.hpp"

#include <algorithm>

namespace voxnav::planning {

using geometry::Index3;

VoxelBox voxels_in(const geometry::Aabb& bounds, double resolution_m) {
  if (bounds.empty()) return {};
  const geometry::Vec3 half = geometry::Vec3::Constant(0.5 * resolution_m - 1e-9 * resolution_m);
  const geometry::Vec3 limit = geometry::Vec3::Constant(1e9 * resolution_m);
  return {geometry::index_of((bounds.min + half).cwiseMax(-limit), resolution_m),
          geometry::index_of((bounds.max - half).cwiseMin(limit), resolution_m)};
}

VoxelBox part_in(const VoxelBox& box, const Index3& block) {
  constexpr int kLast = geometry::kBlockSide - 1;
  const Index3 first = geometry::voxel_at(block, 0);
  const Index3 low = box.low - first, high = box.high - first;
  const VoxelBox out{{std::max(0, low.x), std::max(0, low.y), std::max(0, low.z)},
                     {std::min(kLast, high.x), std::min(kLast, high.y), std::min(kLast, high.z)}};
  return out.low.x > out.high.x || out.low.y > out.high.y || out.low.z > out.high.z ? VoxelBox{} : out;
}

std::size_t ClearanceBlock::max_bytes() { return sizeof(ClearanceBlock) + 2 * sizeof(ClearanceDistances) + 1024; }

std::int32_t ClearanceBlocks::find(const Index3& index) const {
  const auto found = slots_.find(index);
  return found == slots_.end() ? ClearanceBlock::kNoSlot : found->second;
}

std::int32_t ClearanceBlocks::insert(const Index3& index) {
  std::int32_t slot = end();
  if (unused_.empty()) {
    blocks_.emplace_back();
  } else {
    slot = unused_.back();
    unused_.pop_back();
  }
  auto block = std::make_unique<ClearanceBlock>();
  block->index = index;
  block->unknown.fill(kWholeColumn);
  blocks_[static_cast<std::size_t>(slot)] = std::move(block);
  slots_.emplace(index, slot);
  link(slot, index, true);
  return slot;
}

void ClearanceBlocks::remove(std::int32_t slot) {
  const Index3 index = at(slot).index;
  link(slot, index, false);
  slots_.erase(index);
  blocks_[static_cast<std::size_t>(slot)].reset();
  unused_.push_back(slot);
}

void ClearanceBlocks::link(std::int32_t slot, const Index3& index, bool is_there) {
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const std::int32_t other = find(index + Index3{dx, dy, dz});
        at(slot).neighbours[neighbour_at(dx, dy, dz)] = other;
        if (other != ClearanceBlock::kNoSlot) {
          at(other).neighbours[neighbour_at(-dx, -dy, -dz)] = is_there ? slot : ClearanceBlock::kNoSlot;
        }
      }
    }
  }
}

}  // namespace voxnav::planning
