// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::odometry {

/// What a scan is registered to.
enum class RegistrationMethod {
  kMap,   ///< the local map, which is made of many scans
  kIcp,   ///< the scan before, by pcl::IterativeClosestPoint: for comparison only, never for flight
  kGicp,  ///< the scan before, by pcl::GeneralizedIterativeClosestPoint: for comparison only, never for flight
};
constexpr auto words_of(RegistrationMethod) { return std::array{"map", "icp", "gicp"}; }

struct LidarOdometryConfig {
  RegistrationMethod registration = RegistrationMethod::kMap;
  double max_correspondence_distance = 1.0;
  double transformation_epsilon = 1e-8;
  double min_range_m = 0.5;
  double max_range_m = 80.0;
  double voxel_size_m = 0.6;
  int max_points_per_voxel = 12;
  int max_map_voxels = 60000;
  int max_source_points = 3000;
  int max_iterations = 20;
  double initial_threshold_m = 2.0;
  double min_threshold_m = 0.3;
  double inlier_distance_m = 0.25;
  double min_inlier_ratio = 0.35;
  int min_matched_points = 60;
  double weak_translation = 0.006;
  double weak_rotation = 0.001;
  double measurement_noise_m = 0.1;
  double acceleration_noise_mps2 = 4.0;
  double velocity_noise_mps = 0.5;
  double max_acceleration_mps2 = 30.0;
  double max_speed_mps = 25.0;
  double gyro_noise_radps = 0.02;
  double drift_ratio = 0.005;
  double coast_velocity_decay_s = 2.0;
  double restart_after_s = 3.0;
  double imu_max_gap_s = 0.05;
  bool use_imu = true;

  template <class V>
  static void fields(V&& v) {
    using C = LidarOdometryConfig;
    v("registration", &C::registration, base::one_of<RegistrationMethod>(), "",
      "what a scan is registered to: map = many scans; icp and gicp = the scan before, by PCL, for comparison, not for "
      "flight");
    v("max_correspondence_distance", &C::max_correspondence_distance, base::in(0.01, 100), "m",
      "icp and gicp: points farther apart do not match");
    v("transformation_epsilon", &C::transformation_epsilon, base::in(0, 1), "",
      "icp and gicp: a step whose square is smaller ends the iterations");
    v("min_range_m", &C::min_range_m, base::in(0, 50), "m", "nearer points are not used");
    v("max_range_m", &C::max_range_m, base::in(2, 300), "m", "farther points are not used; radius of the local map");
    v("voxel_size_m", &C::voxel_size_m, base::in(0.05, 5), "m",
      "voxel of the local map; surfaces are fitted within this radius");
    v("max_points_per_voxel", &C::max_points_per_voxel, base::in(4, 40), "", "points the local map keeps per voxel");
    v("max_map_voxels", &C::max_map_voxels, base::in(1000, 1000000), "",
      "bound of the local map; the farthest voxels go first");
    v("max_source_points", &C::max_source_points, base::in(200, 20000), "", "points of a scan that are registered");
    v("max_iterations", &C::max_iterations, base::in(3, 100), "",
      "Gauss-Newton steps per scan, coarse and fine together");
    v("initial_threshold_m", &C::initial_threshold_m, base::in(0.1, 10), "m",
      "first correspondence threshold, before motion is known");
    v("min_threshold_m", &C::min_threshold_m, base::in(0.05, 5), "m", "least correspondence threshold");
    v("inlier_distance_m", &C::inlier_distance_m, base::in(0.02, 2), "m",
      "residual below which a match supports the pose");
    v("min_inlier_ratio", &C::min_inlier_ratio, base::in(0.05, 0.95), "", "fewer inliers than this: coast");
    v("min_matched_points", &C::min_matched_points, base::in(10, 5000), "", "fewer matches than this: coast");
    v("weak_translation", &C::weak_translation, base::in(0, 0.3), "",
      "share of the information below which a direction is not observed");
    v("weak_rotation", &C::weak_rotation, base::in(0, 0.3), "",
      "share of the information below which a rotation is not observed");
    v("measurement_noise_m", &C::measurement_noise_m, base::in(0.001, 2), "m",
      "standard deviation of one match, correlation between matches included");
    v("acceleration_noise_mps2", &C::acceleration_noise_mps2, base::in(0.01, 50), "m/s^2",
      "deviation from constant velocity");
    v("velocity_noise_mps", &C::velocity_noise_mps, base::in(0.001, 20), "m/s", "error of the velocity that predicts");
    v("max_acceleration_mps2", &C::max_acceleration_mps2, base::in(1, 200), "m/s^2",
      "a registration that needs more is refused");
    v("max_speed_mps", &C::max_speed_mps, base::in(0.5, 100), "m/s", "a registration that needs more is refused");
    v("gyro_noise_radps", &C::gyro_noise_radps, base::in(1e-5, 1), "rad/s",
      "error of the rotation rate, bias included");
    v("drift_ratio", &C::drift_ratio, base::in(0, 0.2), "", "standard deviation of the position per metre travelled");
    v("coast_velocity_decay_s", &C::coast_velocity_decay_s, base::in(0.1, 60), "s",
      "time constant of the velocity while coasting");
    v("restart_after_s", &C::restart_after_s, base::in(0.2, 600), "s",
      "coasting longer than this begins a new local map at the coasted pose");
    v("imu_max_gap_s", &C::imu_max_gap_s, base::in(0.001, 1), "s",
      "longer gaps between samples: the IMU is not used for that scan");
    v("use_imu", &C::use_imu, base::any(), "", "false: constant velocity alone predicts");
  }
  std::vector<std::string> problems() const {
    if (min_range_m < max_range_m) return {};
    return {"min_range_m = " + base::to_string(min_range_m) +
            ": must be below max_range_m = " + base::to_string(max_range_m)};
  }
};

}  // namespace voxnav::odometry
