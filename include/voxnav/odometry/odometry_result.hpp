// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "voxnav/base/time.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::odometry {

/// One sample of an inertial measurement unit, in the axes of the body frame B.
struct ImuSample {
  base::StampNs stamp_ns = 0;
  geometry::Vec3 gyro_radps = geometry::Vec3::Zero();
  geometry::Vec3 accel_mps2 = geometry::Vec3::Zero();  ///< specific force: +g on the axis that points up at rest
};

/// Covariance of a pose. The order is translation x y z, then rotation x y z, all in the axes of frame O.
using Matrix6 = Eigen::Matrix<double, 6, 6>;

/// The state of an odometry, which tells how the pose of a cloud was found. The values are those of
/// msg/OdometryQuality.msg.
enum class OdometryState : std::uint8_t {
  kInitializing = 0,  ///< there is no map to register to yet
  kTracking = 1,      ///< the pose follows from registration
  kCoasting = 2       ///< registration could not be trusted, and the pose follows the prediction
};
constexpr auto words_of(OdometryState) { return std::array{"initializing", "tracking", "coasting"}; }

/// Why an odometry is in the state it is in.
enum class OdometryReason : std::uint8_t {
  kNone,          ///< it tracks in all directions
  kFirstScan,     ///< the map begins with this scan
  kTooFewPoints,  ///< the scan has too few points to begin a map with
  kDegenerate,    ///< it tracks, and some directions follow the prediction
  kFewMatches,    ///< it coasts: too few points match the map
  kFewInliers,    ///< it coasts: too few of the matches fit
  kNotConverged,  ///< it coasts: the registration did not settle
  kMovedTooFar,   ///< it coasts: the registration moved the pose farther than the vehicle can
  kTurnedTooFar,  ///< it coasts: the registration turned the pose farther than the vehicle can
  kOldStamp,      ///< the cloud was refused, because its stamp is not newer than the last
  kStrayStamp,    ///< the cloud was refused, because its stamp is on another clock than those before
};
constexpr auto words_of(OdometryReason) {
  return std::array{"none",          "first_scan",    "too_few_points", "degenerate", "few_matches", "few_inliers",
                    "not_converged", "moved_too_far", "turned_too_far", "old_stamp",  "stray_stamp"};
}

/// The quality of the pose of one cloud.
struct Quality {
  OdometryState state = OdometryState::kInitializing;
  OdometryReason reason_kind = OdometryReason::kNone;
  std::string reason;         ///< reason_kind as a sentence for people; empty for kNone
  double inlier_ratio = 0.0;  ///< inliers among the points that the map could judge
  double residual_m = 0.0;    ///< root mean square distance of the inliers from the map
  int iterations = 0;
  int num_points = 0;  ///< points of the cloud that took part in the registration
  /// How well the surroundings determine the pose: share of the information in each direction of translation, then of
  /// rotation, each smallest first; 1/3 = evenly spread.
  std::array<double, 6> eigenvalues{};
  bool is_degenerate = false;  ///< some direction is not held, and the pose follows the prediction there
};

/// The pose after one cloud.
struct OdometryResult {
  bool is_new = false;  ///< false when the cloud was refused (see quality.reason); all else is then as before it
  base::StampNs stamp_ns = 0;
  geometry::Pose T_O_B = geometry::Pose::Identity();           ///< at the stamp, that is at the start of the sweep
  Matrix6 covariance = Matrix6::Zero();                        ///< translation, rotation; axes of O
  geometry::Vec3 velocity_B = geometry::Vec3::Zero();          ///< m/s, axes of B
  geometry::Vec3 angular_velocity_B = geometry::Vec3::Zero();  ///< rad/s, axes of B
  Quality quality;
};

/// Counts since construction. A refused cloud is not among `clouds`, while a refused sample is among `imu_samples`.
struct OdometryCounters {
  std::uint64_t clouds = 0, clouds_refused = 0, coasted = 0, map_restarts = 0, clock_jumps = 0;
  std::uint64_t points_refused = 0, imu_samples = 0, imu_refused = 0, imu_clock_jumps = 0;
  std::uint64_t imu_not_finite = 0;  ///< among imu_refused
  std::uint64_t scans_without_imu = 0;
};

}  // namespace voxnav::odometry
