// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <optional>
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

/// How far what a submap saw at its ends lies from where it would lie had it not drifted; evenly from its middle.
struct Sway {
  geometry::Vec3 begin_S = geometry::Vec3::Zero();
  geometry::Vec3 end_S = geometry::Vec3::Zero();

  bool is_none() const { return begin_S.isZero(0.0) && end_S.isZero(0.0); }
  geometry::Vec3 at(double phase) const {
    return phase < 0.5 ? (1.0 - 2.0 * phase) * begin_S : (2.0 * phase - 1.0) * end_S;
  }
};

/// When a submap saw what lies somewhere: the mean of its surface points there.
class PhaseGrid {
 public:
  explicit PhaseGrid(const std::vector<geometry::SurfacePoint>& points = {});
  /// One half where there are none.
  double at(const geometry::Vec3& p_S) const;

 private:
  /// Number of the cell that holds a point, if there is one.
  std::optional<std::size_t> cell_of(const geometry::Vec3& p_S) const;

  geometry::Vec3 origin_ = geometry::Vec3::Zero();
  double cell_m_ = 1.0;
  Eigen::Array3i size_ = Eigen::Array3i::Zero();
  std::vector<float> phases_;
};

/// The fixed set of surface points by which a submap is registered to others, and the field that others are
/// registered to. Drawn once: an objective that draws anew at each evaluation has no minimum to converge to.
struct SurfaceSample {
  std::shared_ptr<const geometry::DistanceField> field;
  std::vector<SamplePoint> points;  ///< any prefix is stratified too
  PhaseGrid phases;
  Sway sway;  ///< as the graph knows it by now
};

/// Chooses up to `max_points`, spread evenly over cells of `cell_m` and over upright and level surfaces (which
/// alternate as long as both last), so that plentiful ground does not drown the trunks. Points that are not finite
/// or have no positive weight are left out. Deterministic; O(n log n).
SurfaceSample draw_sample(std::shared_ptr<const geometry::DistanceField> field, int max_points, double cell_m);

/// The first points of a sample against the coarse field of the same surfaces: for the way in from metres away.
SurfaceSample coarsen(const SurfaceSample& sample, int max_points, double cell_m, double reach_m);

}  // namespace voxnav::graph
