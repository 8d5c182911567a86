// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"

namespace voxnav::graph {

/// A surface point chosen for registration.
struct SamplePoint {
  geometry::Vec3 position_S;
  double weight;
  double own_distance_m;  ///< what its own field says there: removes the bias of the field's surface
  bool is_upright;        ///< on a wall or trunk rather than on ground
  geometry::Vec3 normal_S = geometry::Vec3::UnitZ();
  bool is_planar = false;  ///< lies in a plane, of which only the distance along the normal says something
  double phase = 0.5;      ///< when it was seen, as a share of the submap's time
};

/// The fixed set of surface points by which a submap is registered to others, and the field that others are
/// registered to. Drawn once: an objective that draws anew at each evaluation has no minimum to converge to.
struct SurfaceSample {
  std::shared_ptr<const geometry::DistanceField> field;
  std::vector<SamplePoint> points;  ///< any prefix is stratified too
};

/// Chooses up to `max_points`, spread evenly over cells of `cell_m` and over upright and level surfaces (which
/// alternate as long as both last), so that plentiful ground does not drown the trunks. Points that are not finite
/// or have no positive weight are left out. Deterministic; O(n log n).
SurfaceSample draw_sample(std::shared_ptr<const geometry::DistanceField> field, int max_points, double cell_m);

/// The first points of a sample against the coarse field of the same surfaces: for the way in from metres away.
SurfaceSample coarsen(const SurfaceSample& sample, int max_points, double cell_m, double reach_m);

}  // namespace voxnav::graph
