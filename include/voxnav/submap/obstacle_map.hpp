// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <unordered_map>
#include <vector>

#include "voxnav/containers/grid_update.hpp"
#include "voxnav/submap/evidence_map.hpp"

namespace voxnav::submap {

/// Voxels of W nearer to a surface than the safety distance, kept up to date block by block.
/// Occupied: the centre is nearer than safety distance + half a voxel diagonal to a believed surface point, so that no
/// point of a voxel left free is nearer than the safety distance. Free: known free and beyond it. Not thread-safe.
class ObstacleMap {
 public:
  /// @throws std::invalid_argument unless resolution_m > 0 and 0 <= safety_distance_m <= 10
  ObstacleMap(double resolution_m, double safety_distance_m);

  /// Says that the evidence of these blocks changed. They become due, and where a surface changed so do those within
  /// reach.
  void mark_changed(const std::vector<geometry::Index3>& blocks);
  /// Recomputes at most `max_blocks` due blocks. Cost follows them, not the map. @return how many are still due
  std::size_t update(const EvidenceMap& evidence, std::size_t max_blocks);

  const containers::StateGrid& grid() const { return grid_; }
  /// Blocks that changed since the last call, as they are now.
  containers::GridUpdate take_changes();
  containers::GridUpdate snapshot() const { return containers::snapshot_of(grid_); }
  double safety_distance_m() const { return safety_distance_m_; }
  /// Safety distance with the margin that makes it certain.
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
  /// Checksum of the surface points of each block when it was last looked at.
  std::unordered_map<geometry::Index3, std::uint64_t, geometry::Index3Hash> surfaces_;
};

}  // namespace voxnav::submap
