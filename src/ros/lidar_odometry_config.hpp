// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/base/config.hpp"

namespace voxnav_ros {

/// Section `node` of voxnav/LidarOdometry.
struct LidarOdometryNodeConfig {
  std::string odometry_frame = "lidar_odom";
  std::string body_frame = "fcu";
  bool publish_tf = true;
  double imu_wait_s = 0.03;
  double imu_timeout_s = 0.5;

  template <class V>
  static void fields(V&& v) {
    namespace base = voxnav::base;
    using C = LidarOdometryNodeConfig;
    v("odometry_frame", &C::odometry_frame, base::any(), "", "frame O of the poses");
    v("body_frame", &C::body_frame, base::any(), "", "frame B; sensors are mounted on it by tf");
    v("publish_tf", &C::publish_tf, base::any(), "",
      "publish odometry_frame as a child of body_frame, the direction of MRS tf trees");
    v("imu_wait_s", &C::imu_wait_s, base::in(0.0, 1.0), "s",
      "longest time that a cloud waits for IMU samples up to the end of its sweep");
    v("imu_timeout_s", &C::imu_timeout_s, base::in(0.02, 10.0), "s", "an IMU silent for longer is not waited for");
  }
};

}  // namespace voxnav_ros
