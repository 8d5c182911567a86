// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/geometry/pose.hpp"

#include <cmath>

namespace voxnav::geometry {

double yaw_of(const Pose& T_A_B) { return std::atan2(T_A_B.linear()(1, 0), T_A_B.linear()(0, 0)); }

Pose from_position_yaw(const Vec3& position, double yaw_rad) {
  Pose out = Pose::Identity();
  out.linear() = Eigen::AngleAxisd(yaw_rad, Vec3::UnitZ()).toRotationMatrix();
  out.translation() = position;
  return out;
}

Pose gravity_aligned(const Pose& T_A_B) { return from_position_yaw(T_A_B.translation(), yaw_of(T_A_B)); }

double wrap_angle(double angle_rad) {
  constexpr double kTwoPi = 2.0 * M_PI;
  return angle_rad - kTwoPi * std::floor((angle_rad + M_PI) / kTwoPi);
}

Pose interpolate(const Pose& a, const Pose& b, double ratio) {
  const Eigen::Quaterniond q_a(a.linear());
  const Eigen::Quaterniond q_b(b.linear());
  Pose out = Pose::Identity();
  out.linear() = q_a.slerp(ratio, q_b).toRotationMatrix();
  out.translation() = (1.0 - ratio) * a.translation() + ratio * b.translation();
  return out;
}

bool is_valid(const Pose& pose) {
  if (!pose.matrix().allFinite()) return false;
  const Eigen::Matrix3d R = pose.linear();
  return (R * R.transpose() - Eigen::Matrix3d::Identity()).cwiseAbs().maxCoeff() < 1e-3 && R.determinant() > 0.0;
}

}  // namespace voxnav::geometry
