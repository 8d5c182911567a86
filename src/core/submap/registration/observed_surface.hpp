// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "submap/content/submap_content.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// What a submap observed itself, to register it by: distances to the surface points of its own hits alone, observed
/// only within the band around them. What the local map merely remembered is left out, since two submaps that got the
/// same memory fit each other wherever odometry put them. Frozen; thread-safe.
class ObservedSurface final : public geometry::DistanceField {
 public:
  /// Takes what it needs from the submap. O(size of the submap).
  /// @param T_S_B  where the sensor was during the submap, by rising stamps: with it, things that are seen from one
  /// side lie where their middles are (move_to_middles()); without, where they were hit
  explicit ObservedSurface(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B = {});

  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  const std::vector<geometry::SurfacePoint>& surface_points() const override { return observed_->surface_points(); }
  geometry::Aabb surface_bounds() const override { return observed_->surface_bounds(); }
  double resolution_m() const override { return observed_->resolution_m(); }
  std::size_t memory_bytes() const { return observed_->memory_bytes(); }

 private:
  std::shared_ptr<const Submap> observed_;
  std::shared_ptr<const SubmapContent> content_;  ///< of observed_, which never moves to disk
  double reach_m_;
};

}  // namespace voxnav::submap
