// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

class PlacedSubmap;

/// A surface point in a block of the map frame W, and what is known of it.
struct SurfaceEvidence {
  std::uint16_t offset;         ///< geometry::offset_in_block() of its voxel
  occupancy::VoxelPoint point;  ///< hits: its weight
  std::uint8_t range;           ///< from where it was seen: half metres, rounded down; 255 = that or more, or unknown
  bool is_thin : 1;             ///< no surface goes through it: a wire, a pole, a twig
  bool is_new : 1;              ///< an older submap had seen free space here
  bool is_doubted : 1;          ///< a newer submap has seen free space here, which alone proves nothing
  std::uint32_t submap_id;      ///< the submap that it is of; of a removed one, that which removed it

  /// The sensor was at least as near to it as this [m].
  double range_m() const { return range == 255 ? 0.0 : 0.5 * range; }
};
static_assert(sizeof(SurfaceEvidence) == 12, "a map holds millions of them");

/// Position of a surface point of a block in W, whose voxels have edges of `resolution_m`.
geometry::Vec3 point_in_W(const geometry::Index3& block, const SurfaceEvidence& evidence, double resolution_m);

/// What is believed of one block.
struct EvidenceBlock {
  ColumnBlock states;                    ///< occupied exactly where a surface point is, and not free there
  std::vector<SurfaceEvidence> points;   ///< in the order in which submaps gave them
  std::vector<SurfaceEvidence> removed;  ///< taken away by a submap that saw free space. One per voxel, the last
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
  /// Forgets what is known of a block to which submaps are added again: its memory is kept for them.
  void reset_block(const geometry::Index3& block);
  /// Adds what one submap knows of one block. Call in order of age. O(surface points of the block + 16^2).
  void integrate(const geometry::Index3& block, const PlacedSubmap& submap);

  const EvidenceBlock* find(const geometry::Index3& block) const;
  const std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash>& blocks() const { return blocks_; }
  double resolution_m() const { return rules_.resolution_m; }
  containers::State state(const geometry::Vec3& p_W) const;
  /// Position of a surface point of a block in W.
  geometry::Vec3 point_of(const geometry::Index3& block, const SurfaceEvidence& evidence) const;
  /// Nearest believed surface point within max_distance_m; exact. O(blocks within reach), whatever the map's size.
  std::optional<NearestSurface> nearest_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  /// Distance to that point alone.
  std::optional<double> distance_to_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  std::size_t memory_bytes() const;

 private:
  EvidenceRules rules_;
  std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash> blocks_;
};

}  // namespace voxnav::submap
