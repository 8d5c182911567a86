// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"

namespace voxnav::odometry {

struct ScanMatch {
  geometry::Pose T_target_source = geometry::Pose::Identity();
  bool has_converged = false;
  int iterations = 0;
  int num_inliers = 0;      ///< source points within inlier_distance_m of a target point
  double residual_m = 0.0;  ///< root mean square distance of the inliers
};

/// Moves one scan onto another, for odometry without a map. Not thread-safe; deterministic.
class ScanMatcher {
 public:
  virtual ~ScanMatcher() = default;
  /// Points in the frames of their scans, finite; neither list may be empty.
  virtual ScanMatch match(const std::vector<geometry::Vec3f>& source, const std::vector<geometry::Vec3f>& target,
                          const geometry::Pose& guess_T_target_source) = 0;
};

/// The matcher of PCL that the configuration names; none for RegistrationMethod::kMap.
/// @throws std::runtime_error when voxnav was built without PCL
std::unique_ptr<ScanMatcher> make_scan_matcher(const LidarOdometryConfig& config);

}  // namespace voxnav::odometry
