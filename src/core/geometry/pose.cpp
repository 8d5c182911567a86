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

std::optional<Pose> make_pose(const Vec3& position, const Eigen::Quaterniond& q) {
  if (!position.allFinite() || !q.coeffs().allFinite() || std::abs(q.norm() - 1.0) > 0.05) return std::nullopt;
  Pose pose = Pose::Identity();
  pose.linear() = q.normalized().toRotationMatrix();
  pose.translation() = position;
  return pose;
}

Pose as_sent(const Pose& pose) {
  return make_pose(pose.translation(), Eigen::Quaterniond(pose.linear())).value_or(pose);
}

Pose Bend::at(double phase) const {
  const double from_middle = 2.0 * phase - 1.0;
  return from_middle < 0.0 ? interpolate(Pose::Identity(), T_S_begin, -from_middle)
                           : interpolate(Pose::Identity(), T_S_end, from_middle);
}

}  // namespace voxnav::geometry
