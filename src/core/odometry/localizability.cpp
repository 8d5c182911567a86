// SPDX-License-Identifier: BSD-3-Clause
#include "odometry/localizability.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>

namespace voxnav::odometry {
namespace {

using geometry::Vec3;
using geometry::Vec3f;
using Matrix3 = Eigen::Matrix3d;

/// Keeps the inverse defined when the part that is marginalised out is not observed itself; far below any threshold.
constexpr double kRidge = 1e-6;
/// Least cosine between a normal and a direction that it is taken to hold: about 70 degrees.
constexpr float kStrongShare = 0.35F;

Matrix3 schur(const Matrix3& kept, const Matrix3& coupling, const Matrix3& removed) {
  const Matrix3 regular = removed + kRidge * Matrix3::Identity();
  return kept - coupling * regular.ldlt().solve(coupling.transpose());
}

Matrix6 mean_information(const std::vector<Contribution>& contributions) {
  Matrix6 sum = Matrix6::Zero();
  for (const Contribution& c : contributions) {
    Vector6 J;
    J << c.normal.cast<double>(), c.lever.cross(c.normal).cast<double>();
    sum.noalias() += J * J.transpose();
  }
  return sum / static_cast<double>(contributions.size());
}

/// Returns the information about a translation of those matches whose normals clearly point along it.
double strong_translation(const std::vector<Contribution>& contributions, const Vec3& direction) {
  const Vec3f v = direction.cast<float>();
  double sum = 0.0;
  for (const Contribution& c : contributions) {
    const float share = c.normal.dot(v);
    if (std::abs(share) > kStrongShare) sum += share * share;
  }
  return sum / static_cast<double>(contributions.size());
}

/// Returns the information about a rotation about an axis of those matches whose points move clearly along their
/// normals.
/// @param mean_arm_sq  receives the mean square of how far the points move per radian [m^2]
double strong_rotation(const std::vector<Contribution>& contributions, const Vec3& axis, double* mean_arm_sq) {
  const Vec3f v = axis.cast<float>();
  double sum = 0.0, all = 0.0;
  for (const Contribution& c : contributions) {
    const Vec3f motion = v.cross(c.lever);
    const float arm_sq = motion.squaredNorm();
    const float moved = c.normal.dot(motion);
    if (moved * moved > kStrongShare * kStrongShare * arm_sq) sum += moved * moved;
    all += arm_sq;
  }
  *mean_arm_sq = std::max(1e-9, all / static_cast<double>(contributions.size()));
  return sum / std::max(1e-9, all);
}

void keep_if_weak(double value, double weak, const Vec3& direction, double* out, std::vector<Vec3>* directions) {
  *out = std::max(0.0, value);
  if (*out < weak) directions->push_back(direction);
}

}  // namespace

Localizability analyse_localizability(const std::vector<Contribution>& contributions, double weak_translation,
                                      double weak_rotation) {
  const Matrix6 information = mean_information(contributions);
  const Matrix3 tt = information.topLeftCorner<3, 3>(), rr = information.bottomRightCorner<3, 3>();
  const Matrix3 tr = information.topRightCorner<3, 3>();
  const Eigen::SelfAdjointEigenSolver<Matrix3> translation(schur(tt, tr, rr)), rotation(schur(rr, tr.transpose(), tt));
  Localizability out;
  for (int i = 0; i < 3; ++i) {
    const Vec3 direction = translation.eigenvectors().col(i), axis = rotation.eigenvectors().col(i);
    const double held = std::min(translation.eigenvalues()[i], strong_translation(contributions, direction));
    keep_if_weak(held, weak_translation, direction, &out.eigenvalues[static_cast<std::size_t>(i)],
                 &out.weak_translations);
    double arm_sq = 0.0;
    const double strong = strong_rotation(contributions, axis, &arm_sq);
    const double turned = std::min(rotation.eigenvalues()[i] / arm_sq, strong);
    keep_if_weak(turned, weak_rotation, axis, &out.eigenvalues[static_cast<std::size_t>(i) + 3], &out.weak_rotations);
  }
  std::sort(out.eigenvalues.begin(), out.eigenvalues.begin() + 3);
  std::sort(out.eigenvalues.begin() + 3, out.eigenvalues.end());
  return out;
}

Matrix6 without_weak_directions(const Matrix6& information, const Localizability& localizability) {
  Matrix6 strong = Matrix6::Identity();
  for (const Vec3& v : localizability.weak_translations) strong.topLeftCorner<3, 3>() -= v * v.transpose();
  for (const Vec3& v : localizability.weak_rotations) strong.bottomRightCorner<3, 3>() -= v * v.transpose();
  return strong * information * strong;
}

}  // namespace voxnav::odometry
