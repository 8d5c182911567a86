// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/aabb.hpp"

namespace voxnav::geometry {

/// A piece of surface in submap frame S, as registration uses it.
struct SurfacePoint {
  Vec3f position;      ///< m, frame S
  Vec3f normal;        ///< unit, towards free space
  float weight;        ///< > 0, confidence
  float phase = 0.5f;  ///< when it was seen, as a share of the submap's time
};

/// What the graph and the planner may know of a submap. Implementations are immutable, so that
/// several threads may query one field.
class DistanceField {
 public:
  virtual ~DistanceField() = default;

  /// Signed distance (negative inside) and its gradient at a point of frame S.
  /// @param gradient may be null
  /// @return false where the field is unobserved; the outputs are then untouched
  virtual bool sample(const Vec3& p_S, double* distance_m, Vec3* gradient) const = 0;

  virtual const std::vector<SurfacePoint>& surface_points() const = 0;
  /// Box around the surface points, frame S.
  virtual Aabb surface_bounds() const = 0;
  virtual double resolution_m() const = 0;
};

}  // namespace voxnav::geometry
