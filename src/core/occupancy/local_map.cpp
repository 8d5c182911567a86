// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/local_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "occupancy/block_update.hpp"

namespace voxnav::occupancy {
namespace {

/// Rays end at least this far inside the window, so that rounding to float never leads out of it.
constexpr float kBorderVoxels = 1.0f;
constexpr std::size_t kBlocksAtOnce = 8;
constexpr double kZeroRangeM = 1e-6;
constexpr double kMaxCells = 5e8;

double block_size(const LocalMapConfig& config) { return config.resolution_m * geometry::kBlockSide; }

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
      ends_(config_.window_blocks()),
      parts_(static_cast<std::size_t>(config_.num_threads)),
      workers_(std::make_unique<base::WorkerPool>(config_.num_threads)) {}

InsertStatistics LocalMap::insert(const geometry::PointsView& points_L, const geometry::Pose& T_W_L,
                                  const geometry::PointsView& no_return_directions_L) {
  const bool reachable = (T_W_L.translation().array().abs() < kMaxCells * config_.resolution_m).all();
  if (!geometry::is_valid(T_W_L) || !reachable) throw std::invalid_argument("T_W_L is not a usable rigid transform");
  InsertStatistics statistics;
  statistics.points = points_L.size();
  ++sequence_;
  move_window(T_W_L.translation(), &statistics);
  recent_scans_ = std::min(recent_scans_ + 1, SurfaceLeaf::kMaxNumber);
  const ScanFrame frame = frame_of(T_W_L);
  collect_points(points_L, frame, &statistics);
  collect_no_returns(no_return_directions_L, T_W_L, frame);
  sort_ends(points_L, frame);
  cast_rays(to_window(T_W_L.translation()));
  update_blocks(frame, &statistics);
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
    ContentBlock content = evicted.block->content(evicted.index, levels_, recent_scans_);
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

ScanFrame LocalMap::frame_of(const geometry::Pose& T_W_L) const {
  ScanFrame frame;
  frame.rotation = (T_W_L.linear() / config_.resolution_m).cast<float>();
  frame.origin = to_window(T_W_L.translation()).cast<float>();
  frame.low = Eigen::Array3f::Constant(kBorderVoxels);
  frame.high = size_in_voxels(window_).array().cast<float>() - kBorderVoxels;
  frame.nearest_m = static_cast<float>(std::max(config_.min_range_m, kZeroRangeM));
  frame.farthest_m = static_cast<float>(config_.max_range_m);
  frame.clear_beyond_range = config_.clear_beyond_range;
  return frame;
}

void LocalMap::collect_points(const geometry::PointsView& points_L, const ScanFrame& frame,
                              InsertStatistics* statistics) {
  const std::size_t n = points_L.size();
  const std::size_t num_chunks = (n + ScanPart::kChunk - 1) / ScanPart::kChunk;
  workers_->run([&](int worker) {
    const base::Share chunks = base::share_of(num_chunks, worker, workers_->size());
    const std::size_t begin = chunks.begin * ScanPart::kChunk;
    ScanPart& part = parts_[static_cast<std::size_t>(worker)];
    part.clear();
    const geometry::PointsView own = points_L.part(begin, std::min(n, chunks.end * ScanPart::kChunk) - begin);
    part.add(own.data(), own.size(), own.floats_per_point(), frame);
  });
  for (const ScanPart& part : parts_) {
    statistics->rejected_not_finite += part.num_not_finite();
    statistics->rejected_too_near += part.num_too_near();
    statistics->far += part.num_far();
    statistics->outside_window += part.num_outside();
  }
}

void LocalMap::collect_no_returns(const geometry::PointsView& directions_L, const geometry::Pose& T_W_L,
                                  const ScanFrame& frame) {
  no_return_ends_.clear();
  if (config_.no_return_range_m <= 0.0) return;
  const double length = std::min(config_.no_return_range_m, config_.max_range_m) / config_.resolution_m;
  for (std::size_t i = 0; i < directions_L.size(); ++i) {
    const geometry::Vec3 direction = directions_L[i].cast<double>();
    const double norm = direction.norm();
    if (!std::isfinite(norm) || norm < kZeroRangeM) continue;
    const geometry::Vec3 way = T_W_L.linear() * direction * (length / norm);
    no_return_ends_.push_back(frame.clipped(frame.origin + way.cast<float>()));
  }
}

/// The image of the beams and the end voxels do not need each other.
void LocalMap::sort_ends(const geometry::PointsView& points_L, const ScanFrame& frame) {
  const auto sort = [&] {
    ends_.clear();
    for (const ScanPart& part : parts_) ends_.add(part);
    ends_.finish();
  };
  const auto draw = [&] {
    beams_.build(points_L.data(), points_L.size(), points_L.floats_per_point(), frame.nearest_m, frame.farthest_m,
                 frame.clear_beyond_range);
  };
  workers_->run([&](int worker) {
    if (worker == 0) sort();
    if (worker == workers_->size() - 1) draw();
  });
}

void LocalMap::cast_rays(const geometry::Vec3& origin) {
  geometry::Index3 low = geometry::index_of(origin, geometry::kBlockSide);
  geometry::Index3 high = low;
  ends_.widen(&low, &high);
  for (const geometry::Vec3f& end : no_return_ends_) {
    ends_.add_ray(end);
    const geometry::Index3 at = geometry::index_of(end.cast<double>(), geometry::kBlockSide);
    low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
  }
  box_ = ScanBox(window_.num_blocks(), low, high);
  marks_.begin(box_, ends_.rays(), origin);
  base::SharedItems faces(RayMarks::kFaces, 1);
  workers_->run([&](int) {
    for (base::Share share; faces.next(&share);) marks_.cast(static_cast<int>(share.begin));
  });
}

/// Blocks lie anywhere in memory; the next one comes while this one is worked on.
void LocalMap::prefetch(std::uint32_t block) const {
  if (!marks_.is_crossed(block)) return;
  if (const OctreeBlock* known = window_.at(static_cast<int>(box_.slot_of(block)))) known->prefetch();
}

BlockUpdate LocalMap::update_slot(std::uint32_t block, const SurfaceSight& sight) {
  if (!marks_.is_crossed(block)) return {};
  BlockEvidence evidence;
  marks_.add_to(block, &evidence.passed);
  const std::uint32_t slot = box_.slot_of(block);
  const EndVoxels::Range hits = ends_.range(slot);
  evidence.first_voxel = box_.first_voxel(block);
  evidence.hit_bits = ends_.hit_bits(slot);
  evidence.hits_begin = ends_.hits().data() + hits.begin;
  evidence.hits_end = ends_.hits().data() + hits.end;
  evidence.scan_number = recent_scans_;
  OctreeBlock& known = window_.ensure(static_cast<int>(slot), scale_.prior);
  const BlockUpdate update = update_block(&known, evidence, sight, scale_, levels_);
  if (update.any_state_changed) known.changed_at = sequence_;
  return update;
}

/// Every ray crosses its end voxel's block, so the crossed blocks are all blocks.
void LocalMap::update_blocks(const ScanFrame& frame, InsertStatistics* statistics) {
  const MissGuard guard{static_cast<float>(config_.guard_sigmas), static_cast<float>(config_.guard_spread_voxels),
                        static_cast<float>(config_.guard_end_voxels), config_.guard_octants, config_.guard_patience};
  const SurfaceSight sight(beams_, frame, static_cast<float>(config_.resolution_m), guard);
  std::vector<BlockUpdate> updates(parts_.size());
  base::SharedItems blocks(box_.num_blocks(), kBlocksAtOnce);
  workers_->run([&](int worker) {
    BlockUpdate sum;
    for (base::Share share; blocks.next(&share);) {
      for (std::size_t i = share.begin; i < share.end; ++i) {
        if (i + 1 < share.end) prefetch(static_cast<std::uint32_t>(i + 1));  // others may just make what comes then
        sum += update_slot(static_cast<std::uint32_t>(i), sight);
      }
    }
    updates[static_cast<std::size_t>(worker)] = sum;
  });
  statistics->cells_hit = ends_.hits().size();
  for (const BlockUpdate& update : updates) {
    statistics->cells_missed += update.missed;
    statistics->cells_freed += update.became_free;
    statistics->cells_occupied += update.became_occupied;
  }
}

}  // namespace voxnav::occupancy
