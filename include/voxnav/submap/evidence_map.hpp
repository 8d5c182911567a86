// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// A surface point that is still believed, in a voxel of the map frame W.
struct EvidenceLeaf {
  std::uint16_t offset;             ///< geometry::offset_in_block() of its voxel
  std::array<std::int8_t, 3> mean;  ///< from the voxel centre, unit voxel edge / 254
  std::uint32_t submap_id;
};

struct EvidenceBlock {
  containers::StateBlock states;     ///< occupied exactly where a leaf is
  std::vector<EvidenceLeaf> leaves;  ///< in the order in which submaps gave them
};

/// What all submaps together say about W, one block of 16^3 voxels at a time, oldest submap first: newer surface points
/// replace older ones of their voxel, and newer free space removes older points unless the newer submap itself has a
/// surface nearer than the clearing distance (so that small pose errors remove nothing). What a newer submap does not
/// know changes nothing. Source: algorithms.md section 9. Not thread-safe.
class EvidenceMap {
 public:
  EvidenceMap(double resolution_m, double clearing_distance_m);

  void clear_block(const geometry::Index3& block) { blocks_.erase(block); }
  /// Adds what one submap knows of one block. Call in order of age. O(16^3).
  void integrate(const geometry::Index3& block, const Submap& submap, std::uint32_t submap_id,
                 const geometry::Pose& T_W_S);

  const EvidenceBlock* find(const geometry::Index3& block) const;
  const std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash>& blocks() const { return blocks_; }
  double resolution_m() const { return resolution_m_; }
  containers::State state(const geometry::Vec3& p_W) const;
  /// Position of a leaf in W.
  geometry::Vec3 point_of(const geometry::Index3& block, const EvidenceLeaf& leaf) const;
  /// Distance to the nearest believed surface point within max_distance_m; exact.
  std::optional<double> distance_to_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  std::size_t memory_bytes() const;

 private:
  void take_free(const geometry::Index3& index, const Submap& submap, const geometry::Pose& T_G_W,
                 EvidenceBlock* block) const;
  void drop_cleared(const geometry::Index3& index, const Submap& submap, const geometry::Pose& T_G_W,
                    EvidenceBlock* block) const;
  void take_leaves(const geometry::Index3& index, const Submap& submap, std::uint32_t submap_id,
                   const geometry::Pose& T_W_G, EvidenceBlock* block) const;

  double resolution_m_;
  double clearing_distance_m_;
  std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash> blocks_;
};

/// Blocks of W that the known part of a submap touches; sorted.
std::vector<geometry::Index3> footprint(const Submap& submap, const geometry::Pose& T_W_S, double resolution_m);

}  // namespace voxnav::submap
