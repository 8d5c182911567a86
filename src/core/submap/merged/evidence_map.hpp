// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "submap/merged/placed_submap.hpp"

namespace voxnav::submap {

struct EvidenceBlock {
  ColumnBlock states;                ///< occupied exactly where a leaf is, and not free there
  std::vector<EvidenceLeaf> leaves;  ///< in the order in which submaps gave them
  std::vector<EvidenceLeaf> gone;    ///< taken away by a submap that saw free space; its id. One per voxel, the last
};

/// A surface point of the map and how far it is.
struct NearestSurface {
  geometry::Vec3 point_W;
  double distance_m;
};

struct EvidenceRules {
  double resolution_m = 0.4;
  double clearing_distance_m = 0.4;  ///< a submap clears nothing nearer than this to its own surfaces
  double thin_range_m = 6.0;         ///< thin things are cleared from farther only if they were seen from as far
};

/// What all submaps together say about W, one block of 16^3 voxels at a time, oldest submap first: newer surface points
/// replace older ones of their voxel, and newer free space removes older points unless the newer submap itself has a
/// surface nearer than the clearing distance (so that small pose errors remove nothing). Free space is made of voxels
/// that rays crossed, above the ground in them: a point goes only once what is below it was seen too, be it by another
/// submap. Thin things, which beams miss from afar, are removed only by free space that was seen from
/// near. What a newer submap does not know changes nothing. Source: docs/maths/submaps.md, "Newest evidence".
/// Not thread-safe.
class EvidenceMap {
 public:
  /// @throws std::invalid_argument unless the resolution is positive
  explicit EvidenceMap(const EvidenceRules& rules);

  void clear_block(const geometry::Index3& block) { blocks_.erase(block); }
  /// The same for a block that submaps are added to again: its memory is kept for them.
  void reset_block(const geometry::Index3& block);
  /// Adds what one submap knows of one block. Call in order of age. O(leaves of the block + 16^2).
  void integrate(const geometry::Index3& block, const PlacedSubmap& submap);

  const EvidenceBlock* find(const geometry::Index3& block) const;
  const std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash>& blocks() const { return blocks_; }
  double resolution_m() const { return rules_.resolution_m; }
  containers::State state(const geometry::Vec3& p_W) const;
  /// Position of a leaf in W.
  geometry::Vec3 point_of(const geometry::Index3& block, const EvidenceLeaf& leaf) const;
  /// Nearest believed surface point within max_distance_m; exact. O(blocks within reach), whatever the map's size.
  std::optional<NearestSurface> nearest_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  /// Its distance alone.
  std::optional<double> distance_to_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  std::size_t memory_bytes() const;

 private:
  /// What a newer submap says of one block.
  struct Newer {
    const geometry::Index3& index;
    const PlacedSubmap& submap;
    const PlacedLeaves::Around& around;
    const PlacedSubmap::FreeInBlock& free;
    const Columns& seen;  ///< voxels in which it has points
  };
  void drop_older(const Newer& newer, EvidenceBlock* block) const;
  bool doubt(const Newer& newer, EvidenceBlock* block) const;
  void drop_doubted(const Newer& newer, EvidenceBlock* block) const;
  bool is_near_enough(const Newer& newer, const EvidenceLeaf& leaf) const;
  static void add_leaves(const PlacedSubmap& submap, const PlacedLeaves::Block& leaves, EvidenceBlock* block);

  EvidenceRules rules_;
  std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash> blocks_;
};

}  // namespace voxnav::submap
