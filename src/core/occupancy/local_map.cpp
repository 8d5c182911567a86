// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/local_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <thread>

#include "voxnav/occupancy/block_update.hpp"

namespace voxnav::occupancy {
namespace {

/// Rays end at least this far inside the window, so that rounding to float never leads out of it.
constexpr double kBorderVoxels = 1.0;
constexpr double kZeroRangeM = 1e-6;
constexpr double kMaxCells = 5e8;

double block_size(const LocalMapConfig& config) { return config.resolution_m * geometry::kBlockSide; }

/// Largest share of the way from `origin` (inside) to `end` that stays inside.
double share_inside(const geometry::Vec3& origin, const geometry::Vec3& end, const geometry::Vec3& size) {
  double share = 1.0;
  for (int axis = 0; axis < 3; ++axis) {
    const double delta = end[axis] - origin[axis];
    if (delta == 0.0) continue;
    const double border = delta > 0.0 ? size[axis] - kBorderVoxels : kBorderVoxels;
    share = std::min(share, (border - origin[axis]) / delta);
  }
  return std::max(share, 0.0);
}

geometry::Vec3 size_in_voxels(const BlockWindow& window) {
  const auto& n = window.num_blocks();
  return geometry::Vec3(n[0], n[1], n[2]) * geometry::kBlockSide;
}

}  // namespace

LocalMap::LocalMap(const LocalMapConfig& config)
    : config_(base::checked(config)),
      scale_(LogOddsScale::from(config_)),
      levels_(scale_, config_.free_threshold, config_.occupied_threshold),
      window_(config_.window_blocks(), block_size(config_)),
      ends_(config_.window_blocks()) {
  markers_.resize(static_cast<std::size_t>(config_.num_threads));
}

InsertStatistics LocalMap::insert(const float* points, std::size_t n, std::size_t stride, const geometry::Pose& T_W_L) {
  return insert(points, n, stride, nullptr, 0, T_W_L);
}

InsertStatistics LocalMap::insert(const float* points, std::size_t n, std::size_t stride,
                                  const float* no_return_directions, std::size_t m, const geometry::Pose& T_W_L) {
  if (stride < 3) throw std::invalid_argument("points need at least x, y, z");
  const bool reachable = (T_W_L.translation().array().abs() < kMaxCells * config_.resolution_m).all();
  if (!geometry::is_valid(T_W_L) || !reachable) throw std::invalid_argument("T_W_L is not a usable rigid transform");
  InsertStatistics statistics;
  statistics.points = n;
  move_window(T_W_L.translation(), &statistics);
  ends_.clear();
  no_return_ends_.clear();
  collect_points(points, n, stride, T_W_L, &statistics);
  collect_no_returns(no_return_directions, m, T_W_L);
  ends_.finish();
  cast_rays(to_window(T_W_L.translation()));
  weigh_crossings();
  update_blocks(&statistics);
  return statistics;
}

geometry::Vec3 LocalMap::to_window(const geometry::Vec3& point) const {
  const geometry::Index3 first = window_.first_voxel();
  return point / config_.resolution_m - geometry::Vec3(first.x, first.y, first.z);
}

void LocalMap::move_window(const geometry::Vec3& center, InsertStatistics* statistics) {
  BlockWindow::Move move = window_.recenter(center);
  statistics->window_cleared = move.jumped;
  keep_evicted(std::move(move.evicted), statistics);
}

void LocalMap::keep_evicted(std::vector<EvictedBlock> blocks, InsertStatistics* statistics) {
  for (EvictedBlock& evicted : blocks) {
    ++statistics->blocks_evicted;
    if (!evicted.block->has_known()) continue;
    note_removed(evicted.index);
    ContentBlock content = evicted.block->content(evicted.index, levels_);
    for (int i = 0; i < geometry::kBlockVolume; ++i) {
      statistics->cells_evicted += content.states.get(i) != containers::State::kUnknown ? 1 : 0;
    }
    const auto it = evicted_.find(evicted.index);
    if (it != evicted_.end()) {
      MapContent older{config_.resolution_m, {std::move(it->second)}};
      older.merge(MapContent{config_.resolution_m, {std::move(content)}});
      it->second = std::move(older.blocks.front());
    } else if (evicted_.size() < static_cast<std::size_t>(config_.max_evicted_blocks)) {
      evicted_.emplace(evicted.index, std::move(content));
    } else {
      ++evicted_dropped_;
    }
  }
}

void LocalMap::add_clearing(const geometry::Vec3f& origin, geometry::Vec3f end) {
  const double share = share_inside(origin.cast<double>(), end.cast<double>(), size_in_voxels(window_));
  if (share < 1.0) end = origin + static_cast<float>(share) * (end - origin);
  ends_.add_clearing(end);
}

void LocalMap::collect_points(const float* points, std::size_t n, std::size_t stride, const geometry::Pose& T_W_L,
                              InsertStatistics* statistics) {
  // Single precision from here on: window coordinates stay below 10^4 voxels, where it holds 10^-3 of a voxel.
  const geometry::Vec3f origin = to_window(T_W_L.translation()).cast<float>();
  const Eigen::Array3f low = Eigen::Array3f::Constant(kBorderVoxels);
  const Eigen::Array3f high = size_in_voxels(window_).array().cast<float>() - static_cast<float>(kBorderVoxels);
  const Eigen::Matrix3f rotation = (T_W_L.linear() / config_.resolution_m).cast<float>();
  const auto nearest = static_cast<float>(std::max(config_.min_range_m, kZeroRangeM));
  const auto farthest = static_cast<float>(config_.max_range_m);
  for (std::size_t i = 0; i < n; ++i) {
    const Eigen::Map<const geometry::Vec3f> p_L(points + i * stride);
    const float squared_range = p_L.squaredNorm();
    if (!p_L.allFinite()) {
      ++statistics->rejected_not_finite;
    } else if (squared_range < nearest * nearest) {
      ++statistics->rejected_too_near;
    } else if (squared_range > farthest * farthest) {
      ++statistics->far;
      if (config_.clear_beyond_range) add_clearing(origin, origin + rotation * p_L.stableNormalized() * farthest);
    } else {
      const geometry::Vec3f end = origin + rotation * p_L;
      if ((end.array() >= low).all() && (end.array() <= high).all()) {
        ends_.add_hit(end);
      } else {
        ++statistics->outside_window;
        add_clearing(origin, end);
      }
    }
  }
}

void LocalMap::collect_no_returns(const float* directions, std::size_t m, const geometry::Pose& T_W_L) {
  if (config_.no_return_range_m <= 0.0) return;
  const geometry::Vec3 origin = to_window(T_W_L.translation());
  const double length = std::min(config_.no_return_range_m, config_.max_range_m) / config_.resolution_m;
  for (std::size_t i = 0; i < m; ++i) {
    const geometry::Vec3 direction = Eigen::Map<const geometry::Vec3f>(directions + 3 * i).cast<double>();
    const double norm = direction.norm();
    if (!std::isfinite(norm) || norm < kZeroRangeM) continue;
    const geometry::Vec3 end = origin + T_W_L.linear() * direction * (length / norm);
    const double share = share_inside(origin, end, size_in_voxels(window_));
    no_return_ends_.push_back((origin + share * (end - origin)).cast<float>());
  }
}

void LocalMap::cast_rays(const geometry::Vec3& origin) {
  const MissGuard guard{static_cast<float>(config_.guard_sigmas), static_cast<float>(config_.guard_spread_voxels),
                        static_cast<float>(config_.guard_end_voxels)};
  // One block more than the longest ray: the sensor may be anywhere in its own block.
  const int reach = static_cast<int>(std::ceil(config_.max_range_m / block_size(config_))) + 1;
  box_ = ScanBox(window_.num_blocks(), geometry::index_of(origin, geometry::kBlockSide), reach);
  const std::size_t hits = ends_.hits().size();
  const std::size_t clearing = ends_.clearing_ends().size();
  const std::size_t total = hits + clearing + no_return_ends_.size();
  const auto work = [&](std::size_t worker) {
    RayMarker& marker = markers_[worker];
    marker.begin(window_, ends_, box_, guard, origin);
    const std::size_t end = total * (worker + 1) / markers_.size();
    for (std::size_t i = total * worker / markers_.size(); i < end; ++i) {
      if (i < hits) {
        const HitVoxel& hit = ends_.hits()[i];
        marker.cast(ends_.center_of(hit) + hit.points.mean, true);
      } else if (i < hits + clearing) {
        marker.cast(ends_.clearing_ends()[i - hits], true);
      } else {
        marker.cast(no_return_ends_[i - hits - clearing], false);
      }
    }
  };
  std::vector<std::thread> helpers;
  for (std::size_t worker = 1; worker < markers_.size(); ++worker) helpers.emplace_back(work, worker);
  work(0);
  for (std::thread& helper : helpers) helper.join();
  for (std::size_t worker = 1; worker < markers_.size(); ++worker) markers_[0].merge(markers_[worker]);
}

/// Crossings are first all gathered and then judged, so that their order does not matter.
void LocalMap::weigh_crossings() {
  through_.clear();
  const auto& crossings = markers_[0].crossings();
  for (const RayMarker::Crossing& c : crossings) c.leaf->octants |= c.octants;
  for (const RayMarker::Crossing& c : crossings) {
    if (__builtin_popcount(c.leaf->octants) < config_.guard_octants) continue;
    c.leaf->octants = 0;
    if (!c.leaf->is_refuted_by_seeing_through(config_.guard_patience)) continue;
    through_[c.slot][c.offset >> 6] |= std::uint64_t{1} << (c.offset & 63);
  }
}

void LocalMap::update_slot(std::uint32_t slot, BlockEvidence evidence, InsertStatistics* statistics) {
  const auto through = through_.find(slot);
  if (through != through_.end()) evidence.through = &through->second;
  const BlockUpdate done =
      update_block(&window_.ensure(static_cast<int>(slot), scale_.prior), evidence, scale_, levels_);
  statistics->cells_missed += done.missed;
  statistics->cells_freed += done.became_free;
  statistics->cells_occupied += done.became_occupied;
}

/// Every ray crosses its end voxel's block, so the touched blocks are all blocks.
void LocalMap::update_blocks(InsertStatistics* statistics) {
  statistics->cells_hit = ends_.hits().size();
  for (const std::uint32_t block : markers_[0].touched_blocks()) {
    const std::uint32_t slot = box_.slot_of(block);
    const EndVoxels::Range hits = ends_.range(slot);
    update_slot(slot,
                {markers_[0].rows(block), nullptr, ends_.hits().data() + hits.begin, ends_.hits().data() + hits.end},
                statistics);
  }
}

}  // namespace voxnav::occupancy
