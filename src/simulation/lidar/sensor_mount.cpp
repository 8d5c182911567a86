// SPDX-License-Identifier: BSD-3-Clause
#include "sensor_mount.hpp"

namespace voxnav_simulation {

Pose sensor_mount(const std::array<double, 3>& position_m, const std::array<double, 3>& rpy_rad) {
  Pose pose = Pose::Identity();
  pose.linear() = (Eigen::AngleAxisd(rpy_rad[2], Vec3::UnitZ()) * Eigen::AngleAxisd(rpy_rad[1], Vec3::UnitY()) *
                   Eigen::AngleAxisd(rpy_rad[0], Vec3::UnitX()))
                      .toRotationMatrix();
  pose.translation() = Vec3(position_m[0], position_m[1], position_m[2]);
  return pose;
}

}  // namespace voxnav_simulation
