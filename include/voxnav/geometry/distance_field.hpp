// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/aabb.hpp"

namespace voxnav::geometry {

/// A surface point for registration, submap frame S.
struct SurfacePoint {
  Vec3f position;      ///< m, frame S
  Vec3f normal;        ///< unit, towards free space
  float weight;        ///< > 0, confidence
  float phase = 0.5f;  ///< time at which it was seen: 0 at the submap's beginning, 1 at its end
};

/// The interface through which the graph sees a submap: signed distances and surface points. Implementations are
/// immutable, so that several threads may query one field.
class DistanceField {
 public:
  virtual ~DistanceField() = default;

  /// Returns the signed distance (negative inside) and its gradient at a point of frame S.
  /// @param gradient  may be null
  /// @return false where the field is unobserved; the outputs are then untouched
  virtual bool sample(const Vec3& p_S, double* distance_m, Vec3* gradient) const = 0;

  virtual const std::vector<SurfacePoint>& surface_points() const = 0;
  /// The bounding box of the surface points, frame S.
  virtual Aabb surface_bounds() const = 0;
  virtual double resolution_m() const = 0;
};

}  // namespace voxnav::geometry
