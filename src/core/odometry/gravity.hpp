// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <optional>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::odometry {

/// The specific force over a time span, in the unit and the axes of the samples.
struct MeanForce {
  geometry::Vec3 mean = geometry::Vec3::Zero();
  double mean_norm = 0.0;  ///< mean of the norms, which is above the norm of the mean if directions differ
};

/// Finds the direction of the vertical from the specific force that an IMU measures. Its norm only has to be that of
/// gravity within 40 % in m/s^2, g, mg, cm/s^2 or mm/s^2, because IMUs give any of these units.
class Gravity {
 public:
  /// Returns the upward direction in the axes of the samples, for a body that does not accelerate; nothing if the
  /// samples disagree, or if their norm is not that of gravity.
  static std::optional<geometry::Vec3> up_at_rest(const MeanForce& force);

  /// Adds a time span that follows the one before without a gap. All is in frame O, which need not be level.
  /// @param force_O  mean specific force, rotated into frame O, in the unit of the samples
  /// @param from_O, to_O  positions at both ends of the span
  void add(const geometry::Vec3& force_O, const geometry::Vec3& from_O, const geometry::Vec3& to_O, double dt_s);
  void clear() { *this = Gravity(); }
  /// Returns the upward direction in frame O from all spans since clear(), for a body that may have accelerated;
  /// nothing before these cover `least_s`. O(1).
  std::optional<geometry::Vec3> up_O(double least_s) const;

 private:
  /// Sums over the times t at which positions are known: of t^k, of t^k times the position, and of t^k times the force
  /// that was integrated twice.
  struct Moments {
    std::array<double, 5> time{};
    std::array<geometry::Vec3, 3> position{geometry::Vec3::Zero(), geometry::Vec3::Zero(), geometry::Vec3::Zero()};
    std::array<geometry::Vec3, 3> pushed{geometry::Vec3::Zero(), geometry::Vec3::Zero(), geometry::Vec3::Zero()};
  };
  void note(const geometry::Vec3& position_O);

  double span_s_ = 0.0;
  geometry::Vec3 force_s_ = geometry::Vec3::Zero();   // integral of the force, in the unit of the samples
  geometry::Vec3 force_s2_ = geometry::Vec3::Zero();  // integral of that integral
  Moments moments_;
};

/// Returns the rotation with heading zero that maps `up` to the z axis.
Eigen::Matrix3d levelling(const geometry::Vec3& up);

}  // namespace voxnav::odometry
