// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/geometry/rigid_pose.hpp"

#include <cmath>

namespace voxnav::geometry {

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

}  // namespace voxnav::geometry
