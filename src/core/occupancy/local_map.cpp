// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/local_map.hpp"

#include <algorithm>
#include <cmath>
#include <set>
#include <stdexcept>

#include "occupancy/local_map_impl.hpp"

namespace voxnav::occupancy {
namespace {

constexpr double kMaxCells = 5e8;

}  // namespace

LocalMap::LocalMap(const LocalMapConfig& config) : impl_(std::make_unique<Impl>(base::checked(config))) {}
LocalMap::~LocalMap() = default;
LocalMap::LocalMap(LocalMap&&) noexcept = default;
LocalMap& LocalMap::operator=(LocalMap&&) noexcept = default;

const LocalMapConfig& LocalMap::config() const { return impl_->config; }
std::uint64_t LocalMap::sequence() const { return impl_->forest.sequence; }

InsertStatistics LocalMap::insert(const geometry::PointsView& points_L, const geometry::Pose& T_W_L,
                                  const geometry::PointsView& no_return_directions_L, const ScanLimits& limits) {
  const bool reachable = (T_W_L.translation().array().abs() < kMaxCells * impl_->config.resolution_m).all();
  if (!geometry::is_valid(T_W_L) || !reachable) throw std::invalid_argument("T_W_L is not a usable rigid transform");
  if (!(limits.max_range_m > 0.0) || !(limits.range_noise_m >= 0.0))
    throw std::invalid_argument("a scan needs a positive max_range_m, and no negative range_noise_m");
  OctreeForest& forest = impl_->forest;
  InsertStatistics statistics;
  statistics.points = points_L.size();
  ++forest.sequence;
  BlockWindow::Move move = forest.window.recenter(T_W_L.translation());
  statistics.window_cleared = move.jumped;
  impl_->keep(std::move(move.evicted), &statistics);
  forest.recent_scans = std::min(forest.recent_scans + 1, SurfaceLeaf::kMaxNumber);
  ++forest.scans;
  impl_->insertion.run({points_L, no_return_directions_L, T_W_L, limits, impl_->bodies}, &forest, &statistics);
  impl_->num_new_not_kept += statistics.new_not_kept;
  return statistics;
}

void LocalMap::set_bodies(std::vector<BodyBall> bodies) {
  for (const BodyBall& body : bodies) {
    if (!body.center.allFinite() || !(body.radius_m >= 0.0)) throw std::invalid_argument("a body is not finite");
  }
  impl_->bodies = std::move(bodies);
}

void LocalMap::Impl::keep(std::vector<EvictedBlock> blocks, InsertStatistics* statistics) {
  for (EvictedBlock& left : blocks) {
    ++statistics->blocks_evicted;
    if (!left.block->has_known()) continue;
    removed.add(left.index, forest.sequence);
    ContentBlock content = left.block->content(left.index, forest.levels, forest.recent_scans);
    for (int i = 0; i < geometry::kBlockVolume; ++i) {
      statistics->cells_evicted += content.states.get(i) != containers::VoxelState::kUnknown ? 1 : 0;
    }
    evicted.add(std::move(content));
  }
}

void LocalMap::place_window(const geometry::Vec3& center) { impl_->forest.window.recenter(center); }

void LocalMap::clear() {
  OctreeForest& forest = impl_->forest;
  ++forest.sequence;
  for (const EvictedBlock& block : forest.window.take_all()) impl_->removed.add(block.index, forest.sequence);
  impl_->evicted.clear();
  impl_->moving.clear();
  forest.recent_scans = 0;
}

void LocalMap::set_thresholds(double free_threshold, double occupied_threshold) {
  LocalMapConfig changed = impl_->config;
  changed.free_threshold = free_threshold;
  changed.occupied_threshold = occupied_threshold;
  impl_->config = base::checked(changed);
  OctreeForest& forest = impl_->forest;
  forest.levels = StateLevels(forest.scale, free_threshold, occupied_threshold);
  ++forest.sequence;
  for (int slot = 0; slot < forest.window.num_slots(); ++slot) {
    if (forest.window.at(slot) != nullptr) forest.refresh(slot);
  }
}

std::size_t LocalMap::assign(const std::vector<VoxelLogOdds>& voxels) {
  OctreeForest& forest = impl_->forest;
  ++forest.sequence;
  std::set<int> touched;
  std::size_t num_set = 0;
  for (const VoxelLogOdds& voxel : voxels) {
    if (!forest.contains(voxel.point) || !std::isfinite(voxel.log_odds)) continue;
    const geometry::Index3 index = geometry::index_of(voxel.point, forest.resolution_m);
    const int slot = forest.window.slot_of(geometry::block_of(index));
    const double level = std::round(forest.scale.prior + voxel.log_odds * forest.scale.levels_per_unit);
    OctreeBlock& block = forest.window.ensure(slot, forest.scale.prior);
    const int offset = geometry::offset_in_block(index);
    block.log_odds[offset] = static_cast<std::uint8_t>(std::clamp(level, 0.0, static_cast<double>(forest.scale.max)));
    block.mark_seen(offset);
    block.new_voxels.erase(offset);
    touched.insert(slot);
    ++num_set;
  }
  for (const int slot : touched) forest.refresh(slot);
  return num_set;
}

std::size_t LocalMap::mark_free(const geometry::Vec3& center, double radius_m) {
  if (!center.allFinite() || !(radius_m >= 0.0))
    throw std::invalid_argument("mark_free needs a finite centre and radius");
  OctreeForest& forest = impl_->forest;
  if (!forest.window.is_placed()) forest.window.recenter(center);
  ++forest.sequence;
  const double reach = std::min(radius_m, impl_->config.max_range_m);
  const geometry::Index3 low = geometry::index_of(center.array() - reach, forest.resolution_m);
  const geometry::Index3 high = geometry::index_of(center.array() + reach, forest.resolution_m);
  std::set<int> touched;
  std::size_t freed = 0;
  geometry::Index3 v;
  for (v.z = low.z; v.z <= high.z; ++v.z) {
    for (v.y = low.y; v.y <= high.y; ++v.y) {
      for (v.x = low.x; v.x <= high.x; ++v.x) {
        const int slot = forest.window.slot_of(geometry::block_of(v));
        const bool near = (geometry::center_of(v, forest.resolution_m) - center).norm() <= reach;
        if (slot < 0 || !near) continue;
        OctreeBlock& block = forest.window.ensure(slot, forest.scale.prior);
        const int offset = geometry::offset_in_block(v);
        std::uint8_t& level = block.log_odds[offset];
        if (level >= forest.levels.occupied_min) continue;
        block.mark_seen(offset);
        if (level == 0) continue;
        freed += forest.levels.of(level) != containers::VoxelState::kFree ? 1 : 0;
        level = 0;
        touched.insert(slot);
      }
    }
  }
  for (const int slot : touched) forest.refresh(slot);
  return freed;
}

std::size_t LocalMap::memory_bytes() const {
  return sizeof(*this) + sizeof(Impl) - sizeof(BlockWindow) + impl_->forest.window.memory_bytes() +
         impl_->insertion.memory_bytes() + impl_->evicted.memory_bytes() + impl_->removed.memory_bytes() +
         impl_->moving.capacity() * sizeof(geometry::Index3);
}

}  // namespace voxnav::occupancy
