// SPDX-License-Identifier: BSD-3-Clause
// The outputs of a local map: points, content for submaps, and changes for readers.
#include "occupancy/local_map_impl.hpp"

namespace voxnav::occupancy {
namespace {

template <class Wanted>
std::vector<float> centers_where(const OctreeForest& forest, Wanted wanted) {
  std::vector<float> out;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      if (!wanted(block.log_odds[offset])) continue;
      const geometry::Vec3 center = geometry::center_of(geometry::voxel_at(index, offset), forest.resolution_m);
      for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(center[axis]));
    }
  });
  return out;
}

}  // namespace

std::vector<float> LocalMap::centers_above(double probability) const {
  const int lowest = impl_->forest.scale.lowest_above(probability);
  return centers_where(impl_->forest, [=](int level) { return level >= lowest; });
}

std::vector<float> LocalMap::centers_below(double probability) const {
  const int highest = impl_->forest.scale.highest_below(probability);
  return centers_where(impl_->forest, [=](int level) { return level <= highest; });
}

std::vector<float> LocalMap::occupied_points() const {
  std::vector<float> out;
  const OctreeForest& forest = impl_->forest;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    if ((block.root_flags() & kContainsOccupied) == 0) return;
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      if (block.log_odds[offset] < forest.levels.occupied_min) continue;
      geometry::Vec3 point = geometry::center_of(geometry::voxel_at(index, offset), forest.resolution_m);
      if (const SurfaceLeaf* leaf = block.leaves.find(offset))
        point += leaf->offset().cast<double>() * forest.resolution_m;
      for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(point[axis]));
    }
  });
  return out;
}

void LocalMap::for_known(const std::function<void(const KnownVoxel&)>& visit) const {
  const OctreeForest& forest = impl_->forest;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    if (!block.has_known()) return;
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const int level = block.log_odds[offset];
      const containers::VoxelState state = forest.levels.of(level);
      if (state == containers::VoxelState::kUnknown) continue;
      visit({geometry::voxel_at(index, offset), state, forest.scale.log_odds(level)});
    }
  });
}

MapContent LocalMap::content() const {
  MapContent out;
  const OctreeForest& forest = impl_->forest;
  out.resolution_m = forest.resolution_m;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    if (block.has_known()) out.blocks.push_back(block.content(index, forest.levels, forest.recent_scans));
  });
  return out;
}

MapContent LocalMap::hand_over() {
  MapContent out = content();
  OctreeForest& forest = impl_->forest;
  forest.recent_scans = 0;
  for (int slot = 0; slot < forest.window.num_slots(); ++slot) {
    if (forest.window.at(slot) != nullptr) forest.window.at(slot)->begin_handover();
  }
  return out;
}

MapContent LocalMap::take_evicted() { return impl_->evicted.take(); }
std::size_t LocalMap::num_evicted_pending() const { return impl_->evicted.size(); }
std::size_t LocalMap::num_evicted_dropped() const { return impl_->evicted.num_dropped(); }

containers::GridUpdate LocalMap::Impl::changes_after(std::uint64_t sequence) const {
  if (sequence < removed.complete_since()) return snapshot();
  containers::GridUpdate out;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    if (block.changed_at <= sequence) return;
    if (block.has_known()) {
      out.add(index, block.states(forest.levels));
    } else {
      out.remove(index);
    }
  });
  for (const auto& [index, removed_at] : removed.all()) {
    const OctreeBlock* block = forest.window.find(index);
    const bool is_reported = block != nullptr && (block->has_known() || block->changed_at > sequence);
    if (removed_at > sequence && !is_reported) out.remove(index);
  }
  return out;
}

containers::GridUpdate LocalMap::Impl::snapshot() const {
  containers::GridUpdate out;
  out.is_snapshot = true;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    if (block.has_known()) out.add(index, block.states(forest.levels));
  });
  return out;
}

containers::GridUpdate LocalMap::take_changes() {
  containers::GridUpdate out = impl_->changes_after(impl_->taken_at);
  impl_->taken_at = sequence();
  return out;
}

containers::GridUpdate LocalMap::changes_since(std::uint64_t sequence) const {
  return sequence == 0 || sequence > this->sequence() ? impl_->snapshot() : impl_->changes_after(sequence);
}

containers::GridUpdate LocalMap::snapshot() const { return impl_->snapshot(); }

}  // namespace voxnav::occupancy
