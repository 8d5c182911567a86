// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "submap/merged/free_window.hpp"
#include "submap/merged/placed_leaves.hpp"
#include "voxnav/geometry/bend.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// What of a submap counts: what it saw itself, or also what its local map remembered of submaps before it. The latter
/// lies where odometry put it, which no correction of this submap's pose puts right.
enum class Knowledge { kOwn, kAll };

/// Where a submap lies in W. What it saw itself is bent; memory has no time and stays where the middle is.
struct Placement {
  geometry::Pose T_W_S = geometry::Pose::Identity();
  geometry::Bend bend = {};
};

/// A submap laid into the grid of W: its surface points sorted into the blocks of W and its states as columns, so that
/// each block of W costs no more than what it holds. O(leaves + known blocks). Not thread-safe.
class PlacedSubmap {
 public:
  /// @param viewpoints_W  where the sensor was; none = unknown
  PlacedSubmap(const Submap& submap, std::uint32_t id, const Placement& placement, double resolution_m,
               Knowledge knowledge, std::vector<geometry::Vec3> viewpoints_W = {});

  std::uint32_t id() const { return id_; }
  const PlacedLeaves& leaves() const { return leaves_; }
  /// Distance from a point to where the sensor was nearest to it; nothing when that is not known.
  std::optional<double> range_to(const geometry::Vec3& p_W) const;

  /// What is free of it in one block of W. No longer than the submap lives.
  class FreeInBlock {
   public:
    FreeInBlock(const PlacedSubmap& submap, const geometry::Index3& block);
    /// Bit 1: the point of a leaf lies in free space; bit 0: the place one voxel below it does.
    unsigned at(const PlacedLeaf& leaf) const { return window_ ? window_->at(leaf) : at_tilted(leaf); }
    /// Sets the voxels whose centre the submap knows to be free.
    void add_to(Columns* free) const { window_ ? window_->add_to(free) : add_tilted(free); }

   private:
    unsigned at_tilted(const PlacedLeaf& leaf) const;
    void add_tilted(Columns* free) const;
    bool is_free_at(const geometry::Vec3& p) const;

    const PlacedSubmap* submap_;
    Eigen::Affine3d T_G_W_;    ///< from voxel edges of W to those of G
    geometry::Vec3 origin_W_;  ///< of the block, voxel edges
    std::optional<FreeWindow> window_;
  };

 private:
  void place_leaves(const std::vector<bool>& is_thin);
  geometry::Pose T_W_G_at(double phase) const;
  Eigen::Affine3d T_G_W_of(const geometry::Index3& block) const;
  const Columns* free_of(const geometry::Index3& block_G) const;

  std::shared_ptr<const CompressedField> field_;
  std::uint32_t id_;
  Knowledge knowledge_;
  double resolution_m_;
  double submap_resolution_m_;
  Placement placement_;
  geometry::Pose T_S_G_;
  std::vector<geometry::Vec3> viewpoints_W_;
  bool is_level_;                                       ///< turned about the vertical only, voxels of the same size
  mutable std::vector<std::unique_ptr<Columns>> free_;  ///< per block of the field, once it was asked for
  PlacedLeaves leaves_;
};

/// Poses between which everything of the submap lies.
std::vector<geometry::Pose> extremes(const Placement& placement);

/// Blocks of W that the known part of a submap touches, what counts of it; sorted.
std::vector<geometry::Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                                        Knowledge knowledge);

}  // namespace voxnav::submap
