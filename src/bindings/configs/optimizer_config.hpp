// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Message type of the positions that satellites give: none are used, nav_msgs/Odometry or sensor_msgs/NavSatFix.
enum class GnssType { kNone, kOdometry, kNavSatFix };
constexpr auto words_of(GnssType) { return std::array{"none", "odometry", "navsatfix"}; }

/// Parameters of what the submap_optimizer node and the offline runner do around SubmapGraph: which measurements they
/// add to it, how far these are believed, and what is published.
struct OptimizerConfig {
  std::string map_frame = "map";
  std::string odometry_frame = "odom";
  double odometry_xy_m = 0.1;
  double odometry_xy_mps = 0.02;
  double odometry_z_m = 0.1;
  double odometry_z_mps = 0.02;
  double odometry_yaw_rad = 0.01;
  double odometry_yaw_radps = 0.0005;
  GnssType gnss_type = GnssType::kNone;
  std::array<double, 3> gnss_lever_arm_m{0.0, 0.0, 0.0};
  double gnss_min_sigma_m = 0.02;
  double gnss_max_sigma_m = 10.0;
  int gnss_per_submap = 2;
  double height_sigma_m = 0.5;
  int heights_per_submap = 2;
  double max_bend_m = 1.0;
  int max_pending = 2000;
  int max_queue = 64;
  int distance_cache_mb = 256;
  double tf_rate_hz = 10.0;
  int max_trajectory_poses = 2000;
  int max_marker_lines = 2000;

  template <class V>
  static void fields(V&& v) {
    using C = OptimizerConfig;
    using base::in;
    v("map_frame", &C::map_frame, base::any(), "", "frame W, a child of the odometry frame");
    v("odometry_frame", &C::odometry_frame, base::any(), "", "frame O, until a submap names it");
    v("odometry_xy_m", &C::odometry_xy_m, in(1e-4, 100), "m", "deviation of odometry between submaps, constant part");
    v("odometry_xy_mps", &C::odometry_xy_mps, in(0, 10), "m/s", "growth of that deviation per second between submaps");
    v("odometry_z_m", &C::odometry_z_m, in(1e-4, 100), "m", "deviation of odometry in height, constant part");
    v("odometry_z_mps", &C::odometry_z_mps, in(0, 10), "m/s", "growth of that deviation per second");
    v("odometry_yaw_rad", &C::odometry_yaw_rad, in(1e-5, 3.2), "rad",
      "deviation of odometry in heading, constant part");
    v("odometry_yaw_radps", &C::odometry_yaw_radps, in(0, 1), "rad/s", "growth of that deviation per second");
    v("gnss_type", &C::gnss_type, base::one_of<GnssType>(), "", "message type of ~gnss_in");
    v("gnss_lever_arm_m", &C::gnss_lever_arm_m, in(-10, 10), "m", "antenna in the body frame");
    v("gnss_min_sigma_m", &C::gnss_min_sigma_m, in(1e-3, 100), "m", "lower bound of the standard deviation of a fix");
    v("gnss_max_sigma_m", &C::gnss_max_sigma_m, in(0.01, 1000), "m",
      "fixes with a larger standard deviation are dropped");
    v("gnss_per_submap", &C::gnss_per_submap, in(0, 100), "", "fixes used per submap, spread over its time");
    v("height_sigma_m", &C::height_sigma_m, in(1e-3, 100), "m", "deviation of heights on ~height_in");
    v("heights_per_submap", &C::heights_per_submap, in(0, 100), "", "heights used per submap");
    v("max_bend_m", &C::max_bend_m, in(0, 100), "m",
      "largest drift between the middle of a submap and its ends that is taken out of it; more is a jump; 0 = none is "
      "taken out");
    v("max_pending", &C::max_pending, in(1, 100000), "", "fixes, heights and loops that wait for their submaps");
    v("max_queue", &C::max_queue, in(1, 10000), "", "inputs waiting for the worker; newer ones are refused beyond");
    v("distance_cache_mb", &C::distance_cache_mb, in(1, 100000), "MB",
      "cache of distances around surfaces; those that do not fit are computed again and again (many times slower)");
    v("tf_rate_hz", &C::tf_rate_hz, in(0.1, 200), "Hz", "rate of the map correction on tf");
    v("max_trajectory_poses", &C::max_trajectory_poses, in(10, 1000000), "",
      "poses of ~trajectory_out; thinned beyond");
    v("max_marker_lines", &C::max_marker_lines, in(1, 1000000), "", "constraints drawn, newest submaps first");
  }
};

}  // namespace voxnav::bindings
