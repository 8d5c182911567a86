// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "base/worker_pool.hpp"
#include "occupancy/beam_image.hpp"
#include "occupancy/block_update.hpp"
#include "occupancy/end_voxels.hpp"
#include "occupancy/octree_forest.hpp"
#include "occupancy/ray_marks.hpp"
#include "occupancy/scan_part.hpp"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/occupancy/new_hit.hpp"

namespace voxnav::occupancy {

/// The arguments of LocalMap::insert().
struct SensorScan {
  geometry::PointsView points_L;
  geometry::PointsView no_return_directions_L;
  geometry::Pose T_W_L;
  ScanLimits limits;
  const std::vector<BodyBall>& bodies;
};

/// Inserts scans as hits and misses into an octree forest whose window has already been moved to the sensor. The
/// working memory of one scan is kept for the next.
class ScanInsertion {
 public:
  explicit ScanInsertion(const LocalMapConfig& config);

  /// Inserts a scan and adds its counts of points and voxels to `statistics`.
  void run(const SensorScan& scan, OctreeForest* forest, InsertStatistics* statistics);
  /// The hits of the newest scan in voxels that were believed to be free before, sorted by voxel.
  const std::vector<NewHit>& new_hits() const { return new_hits_; }
  std::size_t memory_bytes() const;

 private:
  ScanFrame frame_of(const SensorScan& scan, const OctreeForest& forest) const;
  float guard_end_voxels(const SensorScan& scan) const;
  void place_bodies(const SensorScan& scan, const OctreeForest& forest);
  /// Finds the voxels of a block that were hit in the body of another vehicle. Returns false if there are none.
  bool find_body_hits(const BlockEvidence& evidence, const OctreeBlock& block, const OctreeForest& forest,
                      VoxelBits* out) const;
  void collect_points(const geometry::PointsView& points_L, const ScanFrame& frame, InsertStatistics* statistics);
  void collect_no_returns(const SensorScan& scan, const ScanFrame& frame);
  void sort_ends(const geometry::PointsView& points_L, const ScanFrame& frame);
  void cast_rays(const geometry::Vec3& origin, const OctreeForest& forest);
  void update_blocks(const ScanFrame& frame, float end_voxels, OctreeForest* forest, InsertStatistics* statistics);
  void prefetch(std::uint32_t block, const OctreeForest& forest) const;
  BlockUpdate update_block(std::uint32_t block, const SurfaceSight& sight, OctreeForest* forest,
                           std::vector<HitOfNew>* hits_of_new) const;
  void collect_new_hits(OctreeForest* forest);

  LocalMapConfig config_;
  EndVoxels ends_;
  std::vector<geometry::Vec3f> no_return_ends_;
  std::vector<BodyBall> bodies_;  ///< in voxels, from the corner of the window
  std::vector<ScanPart> parts_;   ///< one for each thread
  BeamImage beams_;
  ScanBox box_;
  RayMarks marks_;
  std::vector<std::vector<HitOfNew>> hits_of_new_;  ///< one for each thread
  std::vector<NewHit> new_hits_;
  std::unique_ptr<base::WorkerPool> workers_;
};

}  // namespace voxnav::occupancy
