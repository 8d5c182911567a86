// SPDX-License-Identifier: BSD-3-Clause
#include "graph/factors.hpp"

#include <cmath>

namespace voxnav::graph {

Pose4 RelativePoseFactor::evaluate(const Pose4& T_W_a, const Pose4& T_W_b, Matrix4* jacobian_a,
                                   Matrix4* jacobian_b) const {
  const double c = std::cos(T_W_a[3]);
  const double s = std::sin(T_W_a[3]);
  Eigen::Matrix3d R_a_W;
  R_a_W << c, s, 0, -s, c, 0, 0, 0, 1;
  const Eigen::Vector3d d = T_W_b.head<3>() - T_W_a.head<3>();
  Pose4 error;
  error << R_a_W * d - T_a_b.head<3>(), geometry::wrap_angle(T_W_b[3] - T_W_a[3] - T_a_b[3]);
  if (jacobian_a) {
    jacobian_a->setZero();
    jacobian_a->topLeftCorner<3, 3>() = -R_a_W;
    jacobian_a->col(3) << -s * d.x() + c * d.y(), -c * d.x() - s * d.y(), 0, -1;
    *jacobian_a = whitening * *jacobian_a;
  }
  if (jacobian_b) {
    jacobian_b->setZero();
    jacobian_b->topLeftCorner<3, 3>() = R_a_W;
    (*jacobian_b)(3, 3) = 1;
    *jacobian_b = whitening * *jacobian_b;
  }
  return whitening * error;
}

namespace {

/// d (R_z(yaw) p) / d yaw
Eigen::Vector3d turned(double yaw_rad, const Eigen::Vector3d& p) {
  const double c = std::cos(yaw_rad);
  const double s = std::sin(yaw_rad);
  return {-s * p.x() - c * p.y(), c * p.x() - s * p.y(), 0};
}

}  // namespace

Eigen::Vector3d PositionFactor::evaluate(const Pose4& T_W_S, const Pose4& T_W_G, Jacobian* jacobian_pose,
                                         Jacobian* jacobian_datum) const {
  if (jacobian_pose) {
    jacobian_pose->leftCols<3>() = whitening;
    jacobian_pose->col(3) = whitening * turned(T_W_S[3], p_S);
  }
  if (jacobian_datum) {
    jacobian_datum->leftCols<3>() = -whitening;
    jacobian_datum->col(3) = -whitening * turned(T_W_G[3], p_G);
  }
  return whitening * (to_pose(T_W_S) * p_S - to_pose(T_W_G) * p_G);
}

Pose4 SeenAt::evaluate(const Pose4& T_W_own, const Pose4& T_W_neighbour, Matrix4* jacobian_own,
                       Matrix4* jacobian_neighbour) const {
  const Pose4& earlier = is_before ? T_W_neighbour : T_W_own;
  const double c = std::cos(earlier[3]);
  const double s = std::sin(earlier[3]);
  const Eigen::Vector3d moved(c * step.x() - s * step.y(), s * step.x() + c * step.y(), step.z());
  const double sign = is_before ? 1.0 : -1.0;  // odometry leads from the neighbour to this submap, or back
  Pose4 out = T_W_own;
  out.head<3>() += share * (T_W_neighbour.head<3>() + sign * moved - T_W_own.head<3>());
  const Eigen::Vector3d turned(-moved.y(), moved.x(), 0.0);
  if (jacobian_own) {
    *jacobian_own = Matrix4::Identity();
    jacobian_own->topLeftCorner<3, 3>() *= 1.0 - share;
    if (!is_before) jacobian_own->topRightCorner<3, 1>() = sign * share * turned;
  }
  if (jacobian_neighbour) {
    *jacobian_neighbour = Matrix4::Zero();
    jacobian_neighbour->topLeftCorner<3, 3>() = share * Eigen::Matrix3d::Identity();
    if (is_before) jacobian_neighbour->topRightCorner<3, 1>() = sign * share * turned;
  }
  return out;
}

}  // namespace voxnav::graph
