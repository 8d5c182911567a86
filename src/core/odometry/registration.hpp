// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "odometry/localizability.hpp"
#include "odometry/point_map.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"

namespace voxnav::odometry {

/// The prior of a registration: the predicted pose with its information.
struct PosePrior {
  geometry::Pose T_O_B = geometry::Pose::Identity();
  Matrix6 information = Matrix6::Zero();  ///< inverse covariance of T_O_B
  double sigma_m = 1.0;                   ///< expected error of T_O_B; points farther than 3 sigma apart do not match
  geometry::Vec3f sensor_up_O = geometry::Vec3f::UnitZ();
};

struct RegistrationResult {
  geometry::Pose T_O_B = geometry::Pose::Identity();
  bool has_converged = false;
  int iterations = 0;
  int num_points = 0;         ///< points of the scan that took part
  int num_matched = 0;        ///< of these, points with a surface of the map near by
  int num_inliers = 0;        ///< of these, points within inlier_distance_m of their surface
  double inlier_ratio = 0.0;  ///< inliers over points that the map could judge
  double residual_m = 0.0;    ///< root mean square distance of the inliers
  Matrix6 information =
      Matrix6::Zero();  ///< sum of weight * J^T J at the result; divide by the noise variance of a match
  Localizability localizability;
};

/// Moves a scan onto the map by point-to-plane and point-to-line matches: iteratively reweighted Gauss-Newton on SE(3)
/// with Geman-McClure weights, first with few points and then with more. Directions that the matches do not determine
/// stay as predicted. Deterministic; at most config.max_iterations steps, each O(points).
/// @param points_B  deskewed points in the body frame, finite
/// @param scan      number of the scan, by which the map decides when to fit surfaces anew
/// Source: Vizzo et al., KISS-ICP, RA-L 2023, section III-C (adaptive gate and weights); Chen and Medioni, Object
/// modelling by registration of multiple range images, Image and Vision Computing 1992 (point-to-plane errors); Zhang
/// et al., On degeneracy of optimization-based state estimation problems, ICRA 2016, section V (weak directions).
RegistrationResult register_scan(const std::vector<geometry::Vec3f>& points_B, const PosePrior& prior,
                                 const LidarOdometryConfig& config, std::uint32_t scan, PointMap* map);

}  // namespace voxnav::odometry
