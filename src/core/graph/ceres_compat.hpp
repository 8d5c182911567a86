// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/problem.h>
#include <ceres/version.h>

#include <algorithm>
#include <cstddef>

#include "voxnav/geometry/pose.hpp"

#define VOXNAV_CERES_HAS_MANIFOLD (CERES_VERSION_MAJOR > 2 || (CERES_VERSION_MAJOR == 2 && CERES_VERSION_MINOR >= 1))
#if VOXNAV_CERES_HAS_MANIFOLD
#include <ceres/manifold.h>
#else
#include <ceres/local_parameterization.h>
#endif

/// Hides the differences between versions of Ceres: 1.14 has LocalParameterization, 2.1 deprecates it for Manifold.
namespace voxnav::graph {

inline void add_wrapped(const double* x, const double* delta, double* x_plus_delta) {
  for (int i = 0; i < 3; ++i) x_plus_delta[i] = x[i] + delta[i];
  x_plus_delta[3] = geometry::wrap_angle(x[3] + delta[3]);
}

inline void set_identity4(double* row_major) {
  std::fill(row_major, row_major + 16, 0.0);
  for (std::size_t i = 0; i < 4; ++i) row_major[5 * i] = 1.0;
}

#if VOXNAV_CERES_HAS_MANIFOLD
/// x, y, z, yaw with yaw kept in [-pi, pi).
class YawManifold final : public ceres::Manifold {
 public:
  int AmbientSize() const override { return 4; }
  int TangentSize() const override { return 4; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    add_wrapped(x, delta, x_plus_delta);
    return true;
  }
  bool PlusJacobian(const double*, double* jacobian) const override {
    set_identity4(jacobian);
    return true;
  }
  bool Minus(const double* y, const double* x, double* y_minus_x) const override {
    for (int i = 0; i < 3; ++i) y_minus_x[i] = y[i] - x[i];
    y_minus_x[3] = geometry::wrap_angle(y[3] - x[3]);
    return true;
  }
  bool MinusJacobian(const double*, double* jacobian) const override {
    set_identity4(jacobian);
    return true;
  }
};

inline void add_pose_block(ceres::Problem* problem, double* pose) {
  problem->AddParameterBlock(pose, 4, new YawManifold);
}
#else
/// x, y, z, yaw with yaw kept in [-pi, pi).
class YawParameterization final : public ceres::LocalParameterization {
 public:
  int GlobalSize() const override { return 4; }
  int LocalSize() const override { return 4; }
  bool Plus(const double* x, const double* delta, double* x_plus_delta) const override {
    add_wrapped(x, delta, x_plus_delta);
    return true;
  }
  bool ComputeJacobian(const double*, double* jacobian) const override {
    set_identity4(jacobian);
    return true;
  }
};

inline void add_pose_block(ceres::Problem* problem, double* pose) {
  problem->AddParameterBlock(pose, 4, new YawParameterization);
}
#endif

}  // namespace voxnav::graph
