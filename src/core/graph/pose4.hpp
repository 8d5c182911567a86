// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::graph {

/// Gravity-aligned pose as the solver sees it: x, y, z [m], yaw [rad].
using Pose4 = Eigen::Vector4d;
using Matrix4 = Eigen::Matrix4d;

/// Returns position and heading of a pose. A tilt of up to 3 degrees is taken for noise of its source and dropped.
/// @throws std::invalid_argument naming `what` if the pose is not finite and rigid, or tilted farther
Pose4 to_pose4(const geometry::Pose& T_A_B, const char* what);
geometry::Pose to_pose(const Pose4& T_A_B);

/// Returns T_A_B from T_W_A and T_W_B; yaw is wrapped.
Pose4 relative(const Pose4& T_W_A, const Pose4& T_W_B);
/// Returns T_A_C from T_A_B and T_B_C; yaw is wrapped.
Pose4 compose(const Pose4& T_A_B, const Pose4& T_B_C);

/// Returns the whitening matrix M with MᵀM = information, so that |M e|² = eᵀ information e. It is Lᵀ of the
/// Cholesky factor, never L (the two differ as soon as the matrix is not diagonal). Semi-definite ones are accepted.
/// @throws std::invalid_argument naming `what` when not finite, not symmetric or indefinite
Matrix4 whitening_of(const Matrix4& information, const char* what);
Eigen::Matrix3d whitening_of_covariance(const Eigen::Matrix3d& covariance, const char* what);

}  // namespace voxnav::graph
