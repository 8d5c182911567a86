// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/scan_insertion.hpp"

#include <algorithm>
#include <cmath>

#include "occupancy/surface_sight.hpp"

namespace voxnav::occupancy {
namespace {

/// Rays end at least this far inside the window [voxel edges], so that rounding to float never leads out of it.
constexpr float kBorderVoxels = 1.0f;
constexpr std::size_t kBlocksAtOnce = 8;
constexpr double kZeroRangeM = 1e-6;

geometry::Vec3 size_in_voxels(const BlockWindow& window) {
  const auto& n = window.num_blocks();
  return geometry::Vec3(n[0], n[1], n[2]) * geometry::kBlockSide;
}

}  // namespace

ScanInsertion::ScanInsertion(const LocalMapConfig& config)
    : config_(config),
      ends_(config.window_blocks()),
      parts_(static_cast<std::size_t>(config.num_threads)),
      hits_of_new_(static_cast<std::size_t>(config.num_threads)),
      workers_(std::make_unique<base::WorkerPool>(config.num_threads)) {}

void ScanInsertion::run(const SensorScan& scan, OctreeForest* forest, InsertStatistics* statistics) {
  const ScanFrame frame = frame_of(scan, *forest);
  collect_points(scan.points_L, frame, statistics);
  collect_no_returns(scan, frame);
  sort_ends(scan.points_L, frame);
  place_bodies(scan, *forest);
  cast_rays(forest->to_window(scan.T_W_L.translation()), *forest);
  update_blocks(frame, guard_end_voxels(scan), forest, statistics);
  collect_new_hits(forest);
}

/// How far behind hits a beam has to end to count against them: twice the noise of its range farther than another.
float ScanInsertion::guard_end_voxels(const SensorScan& scan) const {
  return static_cast<float>(config_.guard_end_voxels + 2.0 * scan.limits.range_noise_m / config_.resolution_m);
}

void ScanInsertion::place_bodies(const SensorScan& scan, const OctreeForest& forest) {
  bodies_.clear();
  for (const BodyBall& body : scan.bodies) {
    bodies_.push_back({forest.to_window(body.center), body.radius_m / config_.resolution_m});
  }
}

/// Voxels that are occupied are something that was there before, and are hit as ever.
bool ScanInsertion::find_body_hits(const BlockEvidence& evidence, const OctreeBlock& block, const OctreeForest& forest,
                                   VoxelBits* out) const {
  const geometry::Vec3 corner(evidence.first_voxel.x, evidence.first_voxel.y, evidence.first_voxel.z);
  bool is_any = false;
  out->fill(0);
  for (const HitVoxel* hit = evidence.hits_begin; hit != evidence.hits_end; ++hit) {
    if (block.log_odds[hit->offset] >= forest.levels.occupied_begin()) continue;
    const geometry::Index3 at = geometry::voxel_at({0, 0, 0}, hit->offset);
    const geometry::Vec3 center = corner + geometry::Vec3(at.x + 0.5, at.y + 0.5, at.z + 0.5);
    for (const BodyBall& body : bodies_) {
      if ((center - body.center).squaredNorm() > body.radius_m * body.radius_m) continue;
      (*out)[hit->offset >> 6] |= std::uint64_t{1} << (hit->offset & 63);
      is_any = true;
      break;
    }
  }
  return is_any;
}

ScanFrame ScanInsertion::frame_of(const SensorScan& scan, const OctreeForest& forest) const {
  ScanFrame frame;
  frame.rotation = (scan.T_W_L.linear() / config_.resolution_m).cast<float>();
  frame.origin = forest.to_window(scan.T_W_L.translation()).cast<float>();
  frame.low = Eigen::Array3f::Constant(kBorderVoxels);
  frame.high = size_in_voxels(forest.window).array().cast<float>() - kBorderVoxels;
  frame.nearest_m = static_cast<float>(std::max(config_.min_range_m, kZeroRangeM));
  frame.farthest_m = static_cast<float>(std::min(config_.max_range_m, scan.limits.max_range_m));
  frame.clear_beyond_range = config_.clear_beyond_range;
  return frame;
}

void ScanInsertion::collect_points(const geometry::PointsView& points_L, const ScanFrame& frame,
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

void ScanInsertion::collect_no_returns(const SensorScan& scan, const ScanFrame& frame) {
  no_return_ends_.clear();
  const double length_m = std::min({config_.no_return_range_m, scan.limits.no_return_range_m, config_.max_range_m});
  if (length_m <= 0.0) return;
  const double length = length_m / config_.resolution_m;
  for (std::size_t i = 0; i < scan.no_return_directions_L.size(); ++i) {
    const geometry::Vec3 direction = scan.no_return_directions_L[i].cast<double>();
    const double norm = direction.norm();
    if (!std::isfinite(norm) || norm < kZeroRangeM) continue;
    const geometry::Vec3 way = scan.T_W_L.linear() * direction * (length / norm);
    no_return_ends_.push_back(frame.clipped(frame.origin + way.cast<float>()));
  }
}

/// Finds the end voxels and draws the beam image. The two do not depend on each other, so with two or more threads they
/// run at the same time.
void ScanInsertion::sort_ends(const geometry::PointsView& points_L, const ScanFrame& frame) {
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

void ScanInsertion::cast_rays(const geometry::Vec3& origin, const OctreeForest& forest) {
  geometry::Index3 low = geometry::index_of(origin, geometry::kBlockSide);
  geometry::Index3 high = low;
  ends_.widen(&low, &high);
  for (const geometry::Vec3f& end : no_return_ends_) {
    ends_.add_ray(end);
    const geometry::Index3 at = geometry::index_of(end.cast<double>(), geometry::kBlockSide);
    low = {std::min(low.x, at.x), std::min(low.y, at.y), std::min(low.z, at.z)};
    high = {std::max(high.x, at.x), std::max(high.y, at.y), std::max(high.z, at.z)};
  }
  box_ = ScanBox(forest.window.num_blocks(), low, high);
  marks_.begin(box_, ends_.rays(), origin);
  base::SharedItems faces(RayMarks::kFaces, 1);
  workers_->run([&](int) {
    for (base::Share share; faces.next(&share);) marks_.cast(static_cast<int>(share.begin));
  });
}

/// Prefetches a block that is updated next. Blocks lie anywhere in memory, so reading one would wait for the memory.
void ScanInsertion::prefetch(std::uint32_t block, const OctreeForest& forest) const {
  if (!marks_.is_crossed(block)) return;
  if (const OctreeBlock* known = forest.window.at(static_cast<int>(box_.slot_of(block)))) known->prefetch();
}

BlockUpdate ScanInsertion::update_block(std::uint32_t block, const SurfaceSight& sight, OctreeForest* forest,
                                        std::vector<HitOfNew>* hits_of_new) const {
  if (!marks_.is_crossed(block)) return {};
  BlockEvidence evidence;
  marks_.add_to(block, &evidence.passed);
  const std::uint32_t slot = box_.slot_of(block);
  const EndVoxels::Range hits = ends_.range(slot);
  evidence.first_voxel = box_.first_voxel(block);
  evidence.hit_bits = ends_.hit_bits(slot);
  evidence.hits_begin = ends_.hits().data() + hits.begin;
  evidence.hits_end = ends_.hits().data() + hits.end;
  evidence.scan_number = forest->recent_scans;
  evidence.scan = forest->scans;
  OctreeBlock& known = forest->window.ensure(static_cast<int>(slot), forest->scale.prior);
  VoxelBits in_bodies;
  if (!bodies_.empty() && find_body_hits(evidence, known, *forest, &in_bodies)) evidence.body_bits = &in_bodies;
  const UpdateRules rules{sight, forest->scale, forest->levels};
  const BlockUpdate update = occupancy::update_block(&known, evidence, rules, hits_of_new);
  if (update.any_state_changed) known.changed_at = forest->sequence;
  return update;
}

/// Updates the blocks that rays cross. These include all blocks with hits, as every ray crosses the block of its end.
void ScanInsertion::update_blocks(const ScanFrame& frame, float end_voxels, OctreeForest* forest,
                                  InsertStatistics* statistics) {
  const MissGuard guard{static_cast<float>(config_.guard_sigmas), static_cast<float>(config_.guard_spread_voxels),
                        end_voxels, config_.guard_octants, config_.guard_patience};
  const SurfaceSight sight(beams_, frame, static_cast<float>(config_.resolution_m), guard);
  std::vector<BlockUpdate> updates(parts_.size());
  base::SharedItems blocks(box_.num_blocks(), kBlocksAtOnce);
  workers_->run([&](int worker) {
    BlockUpdate sum;
    std::vector<HitOfNew>& hits_of_new = hits_of_new_[static_cast<std::size_t>(worker)];
    hits_of_new.clear();
    for (base::Share share; blocks.next(&share);) {
      for (std::size_t i = share.begin; i < share.end; ++i) {
        if (i + 1 < share.end)
          prefetch(static_cast<std::uint32_t>(i + 1), *forest);  // in this share only: other threads create blocks
        sum += update_block(static_cast<std::uint32_t>(i), sight, forest, &hits_of_new);
      }
    }
    updates[static_cast<std::size_t>(worker)] = sum;
  });
  statistics->cells_hit = ends_.hits().size();
  for (const BlockUpdate& update : updates) {
    statistics->cells_missed += update.missed;
    statistics->cells_freed += update.became_free;
    statistics->cells_occupied += update.became_occupied;
    statistics->new_not_kept += update.new_not_kept;
  }
}

/// Threads take blocks as they come, so the hits are sorted: the result must not depend on them.
void ScanInsertion::collect_new_hits(OctreeForest* forest) {
  new_hits_.clear();
  for (const std::vector<HitOfNew>& hits : hits_of_new_) {
    for (const HitOfNew& found : hits) {
      const HitVoxel& hit = *found.hit;
      const geometry::Index3 voxel =
          geometry::voxel_at(forest->window.block_at(static_cast<int>(hit.slot)), hit.offset);
      const geometry::Vec3 at =
          geometry::center_of(voxel, forest->resolution_m) + hit.points.mean.cast<double>() * forest->resolution_m;
      bool is_clear = found.is_clear;
      if (found.is_first) {
        NewVoxel* own = forest->window.at(static_cast<int>(hit.slot))->new_voxels.find(hit.offset);
        is_clear = own->is_clear = own->level_before < forest->scale.miss && !forest->has_surface_beside(voxel);
      }
      new_hits_.push_back({voxel, at.cast<float>(), hit.num_points, found.is_first, is_clear, found.state});
    }
  }
  std::sort(new_hits_.begin(), new_hits_.end(), [](const NewHit& a, const NewHit& b) { return a.voxel < b.voxel; });
}

std::size_t ScanInsertion::memory_bytes() const {
  std::size_t bytes = ends_.memory_bytes() + beams_.memory_bytes() + marks_.memory_bytes();
  for (const ScanPart& part : parts_) bytes += part.memory_bytes();
  for (const std::vector<HitOfNew>& hits : hits_of_new_) bytes += hits.capacity() * sizeof(HitOfNew);
  bytes += new_hits_.capacity() * sizeof(NewHit);
  return bytes + no_return_ends_.capacity() * sizeof(geometry::Vec3f);
}

}  // namespace voxnav::occupancy
