// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "submap/content/submap_content.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// The distance field by which a submap is registered: distances to the surface points that it observed, defined only
/// within the band around them. Content that the local map merely remembered is left out, since two submaps that
/// inherit the same content fit each other wherever odometry put them. Immutable; thread-safe.
class ObservedSurface final : public geometry::DistanceField {
 public:
  /// Copies what it needs from the submap. O(size of the submap).
  /// @param T_S_B  poses of the sensor during the submap, by rising stamps. With them, things that lie in no plane are
  ///               registered by their middles (move_to_middles()), without them by the side that was hit
  explicit ObservedSurface(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B = {});

  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  const std::vector<geometry::SurfacePoint>& surface_points() const override { return observed_->surface_points(); }
  geometry::Aabb surface_bounds() const override { return observed_->surface_bounds(); }
  double resolution_m() const override { return observed_->resolution_m(); }
  std::size_t memory_bytes() const { return observed_->memory_bytes(); }

 private:
  std::shared_ptr<const Submap> observed_;
  std::shared_ptr<const SubmapContent> content_;  ///< content of observed_, which is never moved to disk
  double reach_m_;
};

}  // namespace voxnav::submap
