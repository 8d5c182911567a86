// SPDX-License-Identifier: BSD-3-Clause
// What leaves the local map: points, content, changes. Also the few operations that touch all of it.
#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {
namespace {

/// More removed blocks than this pending means that nobody listens; the next report is then a snapshot.
constexpr std::size_t kMaxRemoved = 10000;

template <class Wanted>
std::vector<float> centers_where(const BlockWindow& window, double resolution_m, Wanted wanted) {
  std::vector<float> out;
  for (int slot = 0; slot < window.num_slots(); ++slot) {
    const OctreeBlock* block = window.at(slot);
    if (block == nullptr) continue;
    const geometry::Index3 index = window.block_at(slot);
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      if (!wanted(block->log_odds[offset])) continue;
      const geometry::Vec3 center = geometry::center_of(geometry::voxel_at(index, offset), resolution_m);
      for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(center[axis]));
    }
  }
  return out;
}

}  // namespace

std::vector<float> LocalMap::centers_above(double probability) const {
  const int lowest = scale_.lowest_above(probability);
  return centers_where(window_, config_.resolution_m, [=](int level) { return level >= lowest; });
}

std::vector<float> LocalMap::centers_below(double probability) const {
  const int highest = scale_.highest_below(probability);
  return centers_where(window_, config_.resolution_m, [=](int level) { return level <= highest; });
}

std::vector<float> LocalMap::occupied_points() const {
  std::vector<float> out;
  for (int slot = 0; slot < window_.num_slots(); ++slot) {
    const OctreeBlock* block = window_.at(slot);
    if (block == nullptr || (block->root_flags() & kContainsOccupied) == 0) continue;
    const geometry::Index3 index = window_.block_at(slot);
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      if (block->log_odds[offset] < levels_.occupied_min) continue;
      geometry::Vec3 point = geometry::center_of(geometry::voxel_at(index, offset), config_.resolution_m);
      if (const SurfaceLeaf* leaf = block->leaves.find(offset))
        point += leaf->offset().cast<double>() * config_.resolution_m;
      for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(point[axis]));
    }
  }
  return out;
}

MapContent LocalMap::content() const {
  MapContent out;
  out.resolution_m = config_.resolution_m;
  for (int slot = 0; slot < window_.num_slots(); ++slot) {
    const OctreeBlock* block = window_.at(slot);
    if (block != nullptr && block->has_known())
      out.blocks.push_back(block->content(window_.block_at(slot), levels_, recent_scans_));
  }
  return out;
}

MapContent LocalMap::hand_over() {
  MapContent out = content();
  recent_scans_ = 0;
  for (int slot = 0; slot < window_.num_slots(); ++slot) {
    if (window_.at(slot) != nullptr) window_.at(slot)->begin_handover();
  }
  return out;
}

MapContent LocalMap::take_evicted() {
  MapContent out;
  out.resolution_m = config_.resolution_m;
  for (auto& entry : evicted_) out.blocks.push_back(std::move(entry.second));
  evicted_.clear();
  return out;
}

void LocalMap::note_removed(const geometry::Index3& block) {
  if (removed_.size() >= kMaxRemoved) {
    removed_.clear();
    complete_since_ = sequence_;
  }
  removed_[block] = sequence_;
}

containers::GridUpdate LocalMap::changes_after(std::uint64_t sequence) const {
  if (sequence < complete_since_) return snapshot();
  containers::GridUpdate out;
  for (int slot = 0; slot < window_.num_slots(); ++slot) {
    const OctreeBlock* block = window_.at(slot);
    if (block == nullptr || block->changed_at <= sequence) continue;
    if (block->has_known()) {
      out.add(window_.block_at(slot), block->states(levels_));
    } else {
      out.remove(window_.block_at(slot));
    }
  }
  for (const auto& [index, removed_at] : removed_) {
    const OctreeBlock* block = window_.find(index);
    const bool is_reported = block != nullptr && (block->has_known() || block->changed_at > sequence);
    if (removed_at > sequence && !is_reported) out.remove(index);
  }
  return out;
}

containers::GridUpdate LocalMap::take_changes() {
  containers::GridUpdate out = changes_after(taken_at_);
  taken_at_ = sequence_;
  return out;
}

containers::GridUpdate LocalMap::changes_since(std::uint64_t sequence) const {
  return sequence == 0 || sequence > sequence_ ? snapshot() : changes_after(sequence);
}

containers::GridUpdate LocalMap::snapshot() const {
  containers::GridUpdate out;
  out.is_snapshot = true;
  for (int slot = 0; slot < window_.num_slots(); ++slot) {
    const OctreeBlock* block = window_.at(slot);
    if (block != nullptr && block->has_known()) out.add(window_.block_at(slot), block->states(levels_));
  }
  return out;
}

void LocalMap::clear() {
  ++sequence_;
  for (const EvictedBlock& block : window_.take_all()) note_removed(block.index);
  evicted_.clear();
  recent_scans_ = 0;
}

void LocalMap::set_thresholds(double free_threshold, double occupied_threshold) {
  LocalMapConfig changed = config_;
  changed.free_threshold = free_threshold;
  changed.occupied_threshold = occupied_threshold;
  config_ = base::checked(changed);
  levels_ = StateLevels(scale_, free_threshold, occupied_threshold);
  ++sequence_;
  for (int slot = 0; slot < window_.num_slots(); ++slot) {
    if (window_.at(slot) != nullptr) refresh(slot);
  }
}

void LocalMap::refresh(int slot) {
  OctreeBlock::Flags flags;
  OctreeBlock* block = window_.at(slot);
  block->leaf_flags(levels_, &flags);
  block->refresh(flags);
  block->changed_at = sequence_;
}

std::size_t LocalMap::assign(const std::vector<VoxelLogOdds>& voxels) {
  ++sequence_;
  std::set<int> touched;
  std::size_t num_set = 0;
  for (const VoxelLogOdds& voxel : voxels) {
    if (!is_in_window(voxel.point) || !std::isfinite(voxel.log_odds)) continue;
    const geometry::Index3 index = geometry::index_of(voxel.point, config_.resolution_m);
    const int slot = window_.slot_of(geometry::block_of(index));
    const double level = std::round(scale_.prior + voxel.log_odds * scale_.levels_per_unit);
    OctreeBlock& block = window_.ensure(slot, scale_.prior);
    const int offset = geometry::offset_in_block(index);
    block.log_odds[offset] = static_cast<std::uint8_t>(std::clamp(level, 0.0, static_cast<double>(scale_.max)));
    block.mark_seen(offset);
    touched.insert(slot);
    ++num_set;
  }
  for (const int slot : touched) refresh(slot);
  return num_set;
}

std::size_t LocalMap::mark_free(const geometry::Vec3& center, double radius_m) {
  if (!center.allFinite() || !(radius_m >= 0.0))
    throw std::invalid_argument("mark_free needs a finite centre and radius");
  if (!window_.is_placed()) window_.recenter(center);
  ++sequence_;
  const double reach = std::min(radius_m, config_.max_range_m);
  const geometry::Index3 low = geometry::index_of(center.array() - reach, config_.resolution_m);
  const geometry::Index3 high = geometry::index_of(center.array() + reach, config_.resolution_m);
  std::set<int> touched;
  std::size_t freed = 0;
  geometry::Index3 v;
  for (v.z = low.z; v.z <= high.z; ++v.z) {
    for (v.y = low.y; v.y <= high.y; ++v.y) {
      for (v.x = low.x; v.x <= high.x; ++v.x) {
        const int slot = window_.slot_of(geometry::block_of(v));
        const bool near = (geometry::center_of(v, config_.resolution_m) - center).norm() <= reach;
        if (slot < 0 || !near) continue;
        OctreeBlock& block = window_.ensure(slot, scale_.prior);
        const int offset = geometry::offset_in_block(v);
        std::uint8_t& level = block.log_odds[offset];
        if (level >= levels_.occupied_min) continue;
        block.mark_seen(offset);
        if (level == 0) continue;
        freed += levels_.of(level) != containers::State::kFree ? 1 : 0;
        level = 0;
        touched.insert(slot);
      }
    }
  }
  for (const int slot : touched) refresh(slot);
  return freed;
}

std::size_t LocalMap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + window_.memory_bytes() + ends_.memory_bytes();
  bytes += beams_.memory_bytes();
  bytes += marks_.memory_bytes();
  for (const ScanPart& part : parts_) bytes += part.memory_bytes();
  for (const auto& entry : evicted_) bytes += sizeof(entry) + entry.second.occupied.capacity() * sizeof(OccupiedLeaf);
  return bytes + removed_.size() * 56 + no_return_ends_.capacity() * sizeof(geometry::Vec3f);
}

}  // namespace voxnav::occupancy
