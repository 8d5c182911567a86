// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <unordered_map>
#include <vector>

#include "voxnav/geometry/bend.hpp"
#include "voxnav/submap/column_block.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// A surface point that is believed, in a voxel of the map frame W.
struct EvidenceLeaf {
  std::uint16_t offset;             ///< geometry::offset_in_block() of its voxel
  std::array<std::int8_t, 3> mean;  ///< from the voxel centre, unit voxel edge / 254
  std::uint8_t hits;                ///< its weight: scans that hit it
  std::uint8_t range;  ///< from where it was seen: half metres, rounded down; 255 = that or more, or unknown
  bool is_thin;        ///< no surface goes through it: a wire, a pole, a twig
  std::uint32_t submap_id;
  bool is_new = false;      ///< an older submap had seen free space here
  bool is_doubted = false;  ///< a newer submap has seen free space here, which alone proves nothing

  /// At least as near somebody was.
  double range_m() const { return range == 255 ? 0.0 : 0.5 * range; }
};

/// Of a leaf, in voxel edges from the corner of its block.
inline geometry::Vec3 local_point(const EvidenceLeaf& leaf) {
  return {(leaf.offset & 15) + 0.5 + leaf.mean[0] / 254.0, ((leaf.offset >> 4) & 15) + 0.5 + leaf.mean[1] / 254.0,
          (leaf.offset >> 8) + 0.5 + leaf.mean[2] / 254.0};
}

/// What of a submap counts: what it saw itself, or also what its local map remembered of submaps before it. The latter
/// lies where odometry put it, which no correction of this submap's pose puts right.
enum class Knowledge { kOwn, kAll };

/// Where a submap lies in W. What it saw itself is bent; memory has no time and stays where the middle is.
struct Placement {
  geometry::Pose T_W_S = geometry::Pose::Identity();
  geometry::Bend bend;
};

/// A submap laid into the grid of W: its surface points sorted into the blocks of W and its states as columns, so that
/// each block of W costs no more than what it holds. O(leaves + known blocks). Not thread-safe.
class PlacedSubmap {
 public:
  /// @param viewpoints_W  where the sensor was; none = unknown
  PlacedSubmap(const Submap& submap, std::uint32_t id, const Placement& placement, double resolution_m,
               Knowledge knowledge, std::vector<geometry::Vec3> viewpoints_W = {});

  std::uint32_t id() const { return id_; }
  /// Sets the voxels of a block of W whose centre the submap knows to be free.
  void add_free(const geometry::Index3& block, Columns* free) const;
  /// Surface points inside a block of W, in the order in which the submap keeps them.
  struct Range {
    const EvidenceLeaf* first = nullptr;
    const EvidenceLeaf* last = nullptr;
    const EvidenceLeaf* begin() const { return first; }
    const EvidenceLeaf* end() const { return last; }
  };
  Range leaves(const geometry::Index3& block) const;
  /// Answers for the leaves of one block of W whether they lie in free space of this submap: the blocks of the submap
  /// that it touches are looked up once. No longer than the submap lives.
  class FreeInBlock {
   public:
    FreeInBlock(const PlacedSubmap& submap, const geometry::Index3& block);
    bool is_free(const EvidenceLeaf& leaf) const { return is_free_at(local_point(leaf)); }
    /// The same of the place one voxel below.
    bool is_free_below(const EvidenceLeaf& leaf) const {
      return is_free_at(local_point(leaf) - geometry::Vec3(0.0, 0.0, 1.0));
    }
    /// Whether this submap hit something nearer than distance_m to a point of W in or near the block.
    bool has_surface_within(const geometry::Vec3& p_W, double distance_m) const;

   private:
    bool is_free_at(const geometry::Vec3& p) const;

    static constexpr int kSide = 4;  ///< a block turned in any way, and one voxel more, touches no more than this
    const PlacedSubmap* submap_;
    geometry::Pose T_G_W_;
    geometry::Vec3 origin_G_;   ///< of the block, in voxels of the submap
    Eigen::Matrix3d R_G_W_;     ///< and a step of one voxel of W
    geometry::Index3 first_G_;  ///< lowest block of the submap that it touches
    mutable std::uint64_t looked_up_ = 0;
    mutable std::array<const Columns*, kSide * kSide * kSide> free_;
  };
  /// Distance from a point to where the sensor was nearest to it; nothing when that is not known.
  std::optional<double> range_to(const geometry::Vec3& p_W) const;

 private:
  struct Group {
    std::uint32_t first = 0;
    std::uint32_t count = 0;
    double time_sum = 0.0;  ///< of its leaves
  };
  void sort_leaves(const std::vector<bool>& is_thin);
  geometry::Pose T_G_W_at(const geometry::Index3& block) const;
  const Columns* free_of(const geometry::Index3& block_G) const;
  bool is_free_voxel(const geometry::Index3& voxel_G) const;
  void add_free_level(const geometry::Index3& block, Columns* free) const;
  void add_free_tilted(const geometry::Index3& block, Columns* free) const;

  std::shared_ptr<const CompressedField> field_;
  double submap_resolution_m_;
  std::uint32_t id_;
  Knowledge knowledge_;
  double resolution_m_;
  geometry::Pose T_S_G_;
  Placement placement_;
  std::vector<geometry::Vec3> viewpoints_W_;
  bool is_level_;                                       ///< turned about the vertical only, voxels of the same size
  mutable std::vector<std::unique_ptr<Columns>> free_;  ///< per block of the field, once it was asked for
  std::vector<EvidenceLeaf> leaves_;
  std::unordered_map<geometry::Index3, Group, geometry::Index3Hash> groups_;
};

/// Poses between which everything of the submap lies.
std::vector<geometry::Pose> extremes(const Placement& placement);

/// Blocks of W that the known part of a submap touches, what counts of it; sorted.
std::vector<geometry::Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                                        Knowledge knowledge);

}  // namespace voxnav::submap
