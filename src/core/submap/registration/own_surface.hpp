// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// What a submap saw itself, to register it by: distances to its own surface points alone, observed only within the
/// band around them. What the local map merely remembered is left out, since two submaps that got the same memory fit
/// each other wherever odometry put them. Frozen; thread-safe.
class OwnSurface final : public geometry::DistanceField {
 public:
  /// Takes what it needs from the submap. O(size of the submap).
  /// @param T_S_B  where the sensor was during the submap, by rising stamps: with it, things that are seen from one
  /// side lie where their middles are (move_to_middles()); without, where they were hit
  explicit OwnSurface(const Submap& submap, const std::vector<geometry::StampedPose>& T_S_B = {});

  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  const std::vector<geometry::SurfacePoint>& surface_points() const override { return own_->surface_points(); }
  geometry::Aabb surface_bounds() const override { return own_->surface_bounds(); }
  double resolution_m() const override { return own_->resolution_m(); }
  std::size_t memory_bytes() const { return own_->memory_bytes(); }

 private:
  std::shared_ptr<const Submap> own_;
  std::shared_ptr<const CompressedField> content_;  ///< of own_, which never moves to disk
  double reach_m_;
};

/// OwnSurface of a submap; the submap itself where its distances were measured by rays, which remember nothing.
std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap,
                                                                  const std::vector<geometry::StampedPose>& T_S_B = {});

}  // namespace voxnav::submap
