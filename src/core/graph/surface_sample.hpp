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
  double own_distance_m;  ///< distance in the submap's own field; subtracting it removes the bias of the field
  bool is_upright;        ///< the point lies on a wall or trunk rather than on the ground
  geometry::Vec3 normal_S = geometry::Vec3::UnitZ();
  bool is_planar = false;  ///< the point lies in a plane, so that only the distance along its normal counts
  double phase = 0.5;      ///< time at which it was seen, as a share of the submap's time
};

/// Drift within a submap: the shift of what it saw at its beginning and at its end against where that would lie without
/// drift. The drift is zero in the middle of the submap's time and grows evenly towards both ends.
struct Sway {
  geometry::Vec3 begin_S = geometry::Vec3::Zero();
  geometry::Vec3 end_S = geometry::Vec3::Zero();

  bool is_none() const { return begin_S.isZero(0.0) && end_S.isZero(0.0); }
  geometry::Vec3 at(double phase) const {
    return phase < 0.5 ? (1.0 - 2.0 * phase) * begin_S : (2.0 * phase - 1.0) * end_S;
  }
};

/// The phase (0 to 1) at which a submap saw what lies at a place, as the mean over the surface points of a cell.
class PhaseGrid {
 public:
  explicit PhaseGrid(const std::vector<geometry::SurfacePoint>& points = {});
  /// Returns the phase at a point; one half, the middle of the submap's time, if its cell has no surface point.
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
/// registered to. It is drawn once, since a cost that draws anew at each evaluation has no minimum to converge to.
struct SurfaceSample {
  std::shared_ptr<const geometry::DistanceField> field;
  std::vector<SamplePoint> points;  ///< ordered so that every prefix is spread as evenly as the whole
  PhaseGrid phases;
  Sway sway;  ///< the present estimate of the graph
};

/// Chooses up to `max_points`, spread evenly over cells of `cell_m` and over upright and level surfaces (which
/// alternate as long as both last), so that plentiful ground does not drown the trunks. Points that are not finite
/// or have no positive weight are left out. Deterministic; O(n log n).
SurfaceSample draw_sample(std::shared_ptr<const geometry::DistanceField> field, int max_points, double cell_m);

/// Returns the first points of a sample with the coarse field of the same surfaces, for registration from metres away.
SurfaceSample coarsen(const SurfaceSample& sample, int max_points, double cell_m, double reach_m);

}  // namespace voxnav::graph
