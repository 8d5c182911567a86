// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::odometry {

/// Specific force over a time span, in the unit and the axes of the samples.
struct MeanForce {
  geometry::Vec3 mean = geometry::Vec3::Zero();
  double mean_norm = 0.0;  ///< of the samples; greater than the norm of their mean where they differ in direction
};

/// Finds out which way is up from the specific force that an IMU measures. The direction decides: the norm only has to
/// be that of gravity within 40 % in m/s^2, g, mg, cm/s^2 or mm/s^2, since IMUs give any of these.
class Gravity {
 public:
  /// Where up is in the axes of the samples, of a body that does not accelerate. Nothing when the samples disagree, or
  /// when their norm is not that of gravity.
  static std::optional<geometry::Vec3> up_at_rest(const MeanForce& force);

  /// A time span in which velocity changed; all in frame O, which need not be level.
  /// @param force_O  mean specific force, rotated into frame O, in the unit of the samples
  void add(const geometry::Vec3& force_O, const geometry::Vec3& velocity_change_O, double dt_s);
  void clear() { *this = Gravity(); }
  /// Where up is in frame O, over all spans since clear(), of a body that may have accelerated. Nothing before
  /// `least_s` of them.
  std::optional<geometry::Vec3> up_O(double least_s) const;

 private:
  geometry::Vec3 force_s_ = geometry::Vec3::Zero();  // integral, in the unit of the samples
  geometry::Vec3 velocity_change_ = geometry::Vec3::Zero();
  double span_s_ = 0.0;
};

/// The rotation with heading zero that turns `up` to the z axis.
Eigen::Matrix3d levelling(const geometry::Vec3& up);

}  // namespace voxnav::odometry
