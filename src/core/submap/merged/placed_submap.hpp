// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <vector>

#include "submap/content/submap_content.hpp"
#include "submap/merged/footprint.hpp"
#include "submap/merged/free_window.hpp"
#include "submap/merged/placed_points.hpp"

namespace voxnav::submap {

/// A submap placed in the grid of W, with its surface points sorted into the blocks of W and its free voxels as
/// columns, so that merging a block of W costs no more than its content. O(surface points + known blocks). Not
/// thread-safe.
class PlacedSubmap {
 public:
  /// @param viewpoints_W  positions of the sensor; empty = unknown
  PlacedSubmap(const Submap& submap, std::uint32_t id, const Placement& placement, double resolution_m,
               Knowledge knowledge, std::vector<geometry::Vec3> viewpoints_W = {});

  std::uint32_t id() const { return id_; }
  const PlacedPoints& points() const { return points_; }
  /// Returns the distance from a point to the nearest position of the sensor; nothing if these are unknown.
  std::optional<double> range_to(const geometry::Vec3& p_W) const;

  /// The free voxels of the submap in one block of W. It must not outlive the submap.
  class FreeInBlock {
   public:
    FreeInBlock(const PlacedSubmap& submap, const geometry::Index3& block);
    FreeAt is_free(const SurfaceEvidence& evidence) const {
      return window_ ? window_->at(evidence) : at_tilted(evidence);
    }
    /// Sets the voxels whose centres lie in free voxels of the submap.
    void add_to(Columns* free) const { window_ ? window_->add_to(free) : add_tilted(free); }

   private:
    FreeAt at_tilted(const SurfaceEvidence& evidence) const;
    void add_tilted(Columns* free) const;
    bool is_free_at(const geometry::Vec3& p) const;

    const PlacedSubmap* submap_;
    Eigen::Affine3d T_G_W_;    ///< transform from voxel edges of W to voxel edges of G
    geometry::Vec3 origin_W_;  ///< corner of the block, voxel edges
    std::optional<FreeWindow> window_;
  };

 private:
  void place_points(const std::vector<bool>& is_thin);
  geometry::Pose T_W_G_at(double phase) const;
  Eigen::Affine3d T_G_W_of(const geometry::Index3& block) const;
  const Columns* free_of(const geometry::Index3& block_G) const;

  std::shared_ptr<const SubmapContent> content_;
  std::uint32_t id_;
  Knowledge knowledge_;
  double resolution_m_;
  double submap_resolution_m_;
  Placement placement_;
  geometry::Pose T_S_G_;
  std::vector<geometry::Vec3> viewpoints_W_;
  bool is_level_;                                       ///< rotated about the vertical only, voxels of the same size
  mutable std::vector<std::unique_ptr<Columns>> free_;  ///< by position of the block; null until first asked for
  PlacedPoints points_;
};

}  // namespace voxnav::submap
