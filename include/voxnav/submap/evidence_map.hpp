// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <unordered_map>
#include <vector>

#include "voxnav/geometry/aabb.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

class PlacedSubmap;

/// A surface point in a block of the map frame W, with the evidence for and against it.
struct SurfaceEvidence {
  std::uint16_t offset;         ///< geometry::offset_in_block() of its voxel
  occupancy::VoxelPoint point;  ///< mean and hits; the number of hits is its weight
  std::uint8_t range;           ///< range from which it was seen, half metres rounded down; 255 = farther, or unknown
  bool is_thin : 1;             ///< no surface goes through it: a wire, a pole, a twig
  bool is_new : 1;              ///< an older submap observed free space here
  bool is_doubted : 1;          ///< a newer submap observed free space here, which alone does not remove the point
  std::uint32_t submap_id;      ///< submap of the point; for a removed point the submap that removed it

  /// The range [m] from which it was seen, rounded down; 0 if it is unknown or too large for the byte.
  double range_m() const { return range == 255 ? 0.0 : 0.5 * range; }
};
static_assert(sizeof(SurfaceEvidence) == 12, "a map holds millions of them");

/// Returns the position in W of a surface point of a block, whose voxels have edges of `resolution_m`.
geometry::Vec3 point_in_W(const geometry::Index3& block, const SurfaceEvidence& evidence, double resolution_m);

/// The merged evidence of one block.
struct EvidenceBlock {
  ColumnBlock states;                    ///< occupied exactly where a believed surface point is, and not free there
  std::vector<SurfaceEvidence> points;   ///< believed surface points, in the order in which submaps added them
  std::vector<SurfaceEvidence> removed;  ///< points that newer free space removed; the last one of each voxel
};

/// A surface point of the map and its distance from a query point.
struct NearestSurface {
  geometry::Vec3 point_W;
  double distance_m;
};

struct EvidenceRules {
  double resolution_m = 0.4;
  double clearing_distance_m = 0.4;  ///< a submap removes no point nearer than this to its own surfaces
  double thin_range_m = 6.0;         ///< thin things are removed from farther only if they were seen from as far
};

/// The evidence of all submaps, merged in the frame W one block of 16^3 voxels at a time, oldest submap first. Newer
/// surface points replace older ones of their voxel. Newer free space removes older points, unless the newer submap
/// itself has a surface nearer than the clearing distance, so that small pose errors remove nothing. A voxel is free
/// because rays crossed it, which they also do above the ground in the same voxel: a point is therefore removed only
/// once the voxel below it was observed as well, by the same submap or another one. Thin things, which beams miss from
/// afar, are removed only by free space that was seen from near. What a newer submap does not know changes nothing.
/// Not thread-safe. Source: docs/maths/submaps.md, section Newest evidence.
class EvidenceMap {
 public:
  /// @throws std::invalid_argument unless the resolution is positive
  explicit EvidenceMap(const EvidenceRules& rules);

  void clear_block(const geometry::Index3& block) { blocks_.erase(block); }
  /// Empties a block before submaps are added to it again; its memory is kept for them.
  void reset_block(const geometry::Index3& index);
  /// Merges the evidence of one submap into one block. Submaps must come in order of age. O(surface points of the block
  /// + 16^2).
  void integrate(const geometry::Index3& index, const PlacedSubmap& submap);

  const EvidenceBlock* find(const geometry::Index3& block) const;
  const std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash>& blocks() const { return blocks_; }
  double resolution_m() const { return rules_.resolution_m; }
  containers::VoxelState state(const geometry::Vec3& p_W) const;
  /// Returns the position of a surface point of a block in W.
  geometry::Vec3 point_of(const geometry::Index3& block, const SurfaceEvidence& evidence) const;
  /// Returns the nearest believed surface point within max_distance_m, exactly. O(blocks within reach), whatever the
  /// size of the map.
  std::optional<NearestSurface> nearest_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  /// Returns the distance to the nearest believed surface point within max_distance_m.
  std::optional<double> distance_to_surface(const geometry::Vec3& p_W, double max_distance_m) const;
  std::size_t memory_bytes() const;

 private:
  EvidenceRules rules_;
  std::unordered_map<geometry::Index3, EvidenceBlock, geometry::Index3Hash> blocks_;
};

/// Something that appeared or disappeared between submaps.
struct SceneChange {
  enum class Kind : std::uint8_t { kAppeared, kDisappeared };
  Kind kind;
  geometry::Aabb box_W;
  geometry::Vec3 center_W;  ///< mean of its surface points
  std::size_t num_voxels = 0;
  std::uint32_t submap_id = 0;  ///< the newest submap that shows the change
};

/// Lists what appeared or disappeared: connected groups (26 neighbours) of at least `min_voxels` voxels whose surface
/// was removed by newer free space, or whose surface is new where older submaps observed free space and have no surface
/// beside it (which would hint at an error of a pose). What appeared comes first, each kind in the order of its first
/// voxel. O(changed voxels).
std::vector<SceneChange> scene_changes(const EvidenceMap& evidence, std::size_t min_voxels);

}  // namespace voxnav::submap
