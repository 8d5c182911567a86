// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/distance_field.hpp"

namespace voxnav::graph {

/// Unsigned distances to a set of surface points on a coarse dense grid, which guide registration from metres away. The
/// field of the submap itself ends where nothing was observed, half a metre beside a trunk; this one is defined
/// everywhere around the surfaces, and a query takes a few nanoseconds.
class CoarseField final : public geometry::DistanceField {
 public:
  /// @param cell_m   spacing of the grid, which is widened if the points span more than 4 million cells
  /// @param reach_m  distance at which distances saturate and the field ends
  CoarseField(const std::vector<geometry::SurfacePoint>& points, double cell_m, double reach_m);

  bool sample(const geometry::Vec3& p_S, double* distance_m, geometry::Vec3* gradient) const override;
  /// Returns an empty list, because the points are not kept.
  const std::vector<geometry::SurfacePoint>& surface_points() const override { return none_; }
  geometry::Aabb surface_bounds() const override { return bounds_; }
  double resolution_m() const override { return cell_m_; }

 private:
  void stamp(const geometry::Vec3& point, double reach_m);

  std::vector<geometry::SurfacePoint> none_;
  geometry::Aabb bounds_;
  geometry::Vec3 origin_ = geometry::Vec3::Zero();
  double cell_m_;
  int size_[3] = {0, 0, 0};
  std::vector<float> distances_m_;
};

}  // namespace voxnav::graph
