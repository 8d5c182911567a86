// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// Obstacles in W: the voxels nearer to a surface than the safety distance, updated block by block. A voxel is occupied
/// if its centre is nearer than the safety distance plus half a voxel diagonal to a believed surface point, so that no
/// point of a free voxel is nearer than the safety distance. A voxel is free if it is known to be free and lies beyond.
/// Not thread-safe.
class ObstacleMap {
 public:
  /// @throws std::invalid_argument unless resolution_m > 0 and 0 <= safety_distance_m <= 10
  ObstacleMap(double resolution_m, double safety_distance_m);

  /// Marks blocks whose evidence changed. They become due, and so do the blocks within reach of surfaces that changed.
  void mark_changed(const std::vector<geometry::Index3>& blocks);
  /// Recomputes at most `max_blocks` due blocks. The cost depends on these blocks and not on the size of the map.
  /// @return number of blocks that are still due
  std::size_t update(const EvidenceMap& evidence, std::size_t max_blocks);

  const containers::StateGrid& grid() const { return grid_; }
  /// Returns the blocks that changed since the last call, with their present states.
  containers::GridUpdate take_changes();
  containers::GridUpdate snapshot() const { return containers::snapshot_of(grid_); }
  double safety_distance_m() const { return safety_distance_m_; }
  /// The safety distance plus the margin of half a voxel diagonal.
  double reach_m() const { return reach_m_; }
  std::size_t memory_bytes() const;

 private:
  void collect_due(const EvidenceMap& evidence);
  bool surface_changed(const geometry::Index3& block, const EvidenceBlock* evidence);

  double safety_distance_m_;
  double reach_m_;
  int reach_blocks_;
  containers::StateGrid grid_;
  std::vector<geometry::Index3> marked_;
  std::vector<geometry::Index3> due_;  ///< sorted backwards, so that the next one is the last
  std::vector<geometry::Index3> changed_;
  /// Checksum of the surface points of each block when it was last compared.
  std::unordered_map<geometry::Index3, std::uint64_t, geometry::Index3Hash> surfaces_;
};

}  // namespace voxnav::submap
