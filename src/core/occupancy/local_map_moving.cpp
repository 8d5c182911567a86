// SPDX-License-Identifier: BSD-3-Clause
// What a local map does with hits of things that move.
#include <algorithm>
#include <map>

#include "occupancy/local_map_impl.hpp"

namespace voxnav::occupancy {
namespace {

/// The number of moving voxels that a map remembers; further ones stay what their hits made of them.
constexpr std::size_t kMaxMoving = 20000;
/// A moving voxel that was not hit for this many scans is left, although no beam was seen to pass through it: there may
/// be nothing behind it that returns beams. As nothing shows that it is free, it becomes unknown.
constexpr std::uint32_t kLeftScans = 10;

OctreeBlock* block_of(OctreeForest* forest, const geometry::Index3& voxel) {
  const int slot = forest->window.slot_of(geometry::block_of(voxel));
  return slot < 0 ? nullptr : forest->window.at(slot);
}

bool is_in(const std::vector<geometry::Aabb>& boxes, const geometry::Vec3& point) {
  return std::any_of(boxes.begin(), boxes.end(), [&](const geometry::Aabb& box) { return box.contains(point); });
}

/// Returns the level of a voxel that something has left. One that a single hit left free stays so.
std::uint8_t level_after(const NewVoxel& voxel, std::uint8_t level, const OctreeForest& forest) {
  if (voxel.is_seen_through) return voxel.level_before;
  return std::min(level, std::max(voxel.level_before, forest.scale.prior));
}

/// The voxels of one block that get a level, and lose their hits.
struct TakenBack {
  VoxelBits voxels{};
  bool has_changed = false;

  void set(OctreeBlock* block, int offset, std::uint8_t level) {
    has_changed = has_changed || block->log_odds[offset] != level;
    block->log_odds[offset] = level;
    voxels[offset >> 6] |= std::uint64_t{1} << (offset & 63);
    block->new_voxels.erase(offset);
  }
  void finish(OctreeBlock* block) const {
    VoxelBits kept = block->leaves.bits();
    for (std::size_t word = 0; word < kept.size(); ++word) kept[word] &= ~voxels[word];
    block->leaves.assign(kept);
  }
};

}  // namespace

const std::vector<NewHit>& LocalMap::new_hits() const { return impl_->insertion.new_hits(); }

std::optional<NewVoxelSight> LocalMap::sight_of_new(const geometry::Index3& voxel) const {
  const OctreeForest& forest = impl_->forest;
  const OctreeBlock* block = forest.window.find(geometry::block_of(voxel));
  const NewVoxel* found = block != nullptr ? block->new_voxels.find(geometry::offset_in_block(voxel)) : nullptr;
  if (found == nullptr) return std::nullopt;
  return NewVoxelSight{forest.scans - found->last_scan, found->is_seen_through};
}

std::uint64_t LocalMap::num_new_not_kept() const { return impl_->num_new_not_kept; }
std::uint64_t LocalMap::num_moving_not_kept() const { return impl_->num_moving_not_kept; }

void LocalMap::mark_moving(const std::vector<geometry::Index3>& voxels) {
  for (const geometry::Index3& index : voxels) {
    OctreeBlock* block = block_of(&impl_->forest, index);
    NewVoxel* voxel = block != nullptr ? block->new_voxels.find(geometry::offset_in_block(index)) : nullptr;
    if (voxel == nullptr || voxel->is_moving) continue;
    if (impl_->moving.size() >= kMaxMoving) {
      ++impl_->num_moving_not_kept;
      continue;
    }
    voxel->is_moving = true;
    impl_->moving.push_back(index);
  }
}

void LocalMap::mark_moving_in(const geometry::Aabb& box) {
  OctreeForest& forest = impl_->forest;
  const int once = forest.scale.prior + forest.scale.hit;
  const geometry::Index3 low = geometry::index_of(box.min, forest.resolution_m);
  const geometry::Index3 high = geometry::index_of(box.max, forest.resolution_m);
  geometry::Index3 v;
  for (v.z = low.z; v.z <= high.z; ++v.z) {
    for (v.y = low.y; v.y <= high.y; ++v.y) {
      for (v.x = low.x; v.x <= high.x; ++v.x) {
        OctreeBlock* block = block_of(&forest, v);
        const int offset = geometry::offset_in_block(v);
        if (block == nullptr || block->log_odds[offset] != once || block->new_voxels.find(offset) != nullptr) continue;
        const SurfaceLeaf* leaf = block->leaves.find(offset);
        if (leaf == nullptr || leaf->scans != 1) continue;
        const NewVoxel added{
            static_cast<std::uint16_t>(offset), forest.scale.prior, false, false, false, forest.scans, forest.scans};
        if (!block->new_voxels.add(added)) {
          ++impl_->num_new_not_kept;
          continue;
        }
        mark_moving({v});
      }
    }
  }
}

void LocalMap::mark_static(const std::vector<geometry::Index3>& voxels) {
  for (const geometry::Index3& index : voxels) {
    if (OctreeBlock* block = block_of(&impl_->forest, index)) block->new_voxels.erase(geometry::offset_in_block(index));
  }
}

std::size_t LocalMap::take_back_moving(const std::vector<geometry::Aabb>& bodies) {
  OctreeForest& forest = impl_->forest;
  std::map<int, TakenBack> taken;  // by slot
  std::size_t count = 0;
  const auto is_done = [&](const geometry::Index3& index) {
    OctreeBlock* block = block_of(&forest, index);
    const int offset = geometry::offset_in_block(index);
    const NewVoxel* voxel = block != nullptr ? block->new_voxels.find(offset) : nullptr;
    if (voxel == nullptr || !voxel->is_moving) return true;
    if (voxel->last_scan == forest.scans && !is_in(bodies, geometry::center_of(index, forest.resolution_m))) {
      block->new_voxels.erase(offset);
      return true;
    }
    const bool is_left = forest.scans - voxel->last_scan > kLeftScans;
    if (!voxel->is_seen_through && !is_left) return false;
    const int slot = forest.window.slot_of(geometry::block_of(index));
    taken[slot].set(block, offset, level_after(*voxel, block->log_odds[offset], forest));
    ++count;
    return true;
  };
  auto& moving = impl_->moving;
  moving.erase(std::remove_if(moving.begin(), moving.end(), is_done), moving.end());
  if (count > 0) ++forest.sequence;
  for (const auto& [slot, block] : taken) {
    block.finish(forest.window.at(slot));
    if (block.has_changed) forest.refresh(slot);
  }
  return count;
}

}  // namespace voxnav::occupancy
