// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "odometry/localizability.hpp"
#include "odometry/point_map.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"

namespace voxnav::odometry {

/// What is believed of the pose before the scan is looked at.
struct PosePrior {
  geometry::Pose T_O_B = geometry::Pose::Identity();
  Matrix6 information = Matrix6::Zero();  ///< about T_O_B
  double sigma_m = 1.0;                   ///< expected error; matches beyond 3 sigma are not made
  geometry::Vec3f sensor_up_O = geometry::Vec3f::UnitZ();
};

struct RegistrationResult {
  geometry::Pose T_O_B = geometry::Pose::Identity();
  bool has_converged = false;
  int iterations = 0;
  int num_points = 0;   ///< scan points that took part
  int num_matched = 0;  ///< with a surface of the map near by
  int num_inliers = 0;
  double inlier_ratio = 0.0;  ///< inliers over points that the map could judge
  double residual_m = 0.0;    ///< RMS over inliers
  Matrix6 information =
      Matrix6::Zero();  ///< sum of weight * J^T J at the result; divide by the noise variance of a match
  Localizability localizability;
};

/// Moves a scan onto the map by point-to-plane and point-to-line matches (iteratively reweighted Gauss-Newton on
/// SE(3), Geman-McClure weights, coarse then fine). Directions the matches do not determine stay as predicted.
/// @param points_B  deskewed points in the body frame, finite
/// Deterministic; at most config.max_iterations steps, each O(points).
/// Source: Vizzo et al. 2023 (KISS-ICP), section III-C (adaptive gate and weights), with point-to-plane errors
/// (Chen & Medioni 1991); remapping: Zhang et al. 2016, section V.
RegistrationResult register_scan(const std::vector<geometry::Vec3f>& points_B, const PosePrior& prior,
                                 const LidarOdometryConfig& config, std::uint32_t scan, PointMap* map);

}  // namespace voxnav::odometry
