// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "voxnav/base/time.hpp"

namespace voxnav::geometry {

using Vec3 = Eigen::Vector3d;
using Vec3f = Eigen::Vector3f;

/// T_A_B maps coordinates in frame B to frame A: p_A = T_A_B * p_B.
using Pose = Eigen::Isometry3d;

struct StampedPose {
  base::StampNs stamp_ns = 0;
  Pose pose = Pose::Identity();
};

/// Heading of a pose. Taken from the rotation matrix, not from a rotation vector, so that it holds for tilted poses.
double yaw_of(const Pose& T_A_B);

/// Gravity-aligned pose (roll = pitch = 0) with the position and heading of T_A_B.
Pose gravity_aligned(const Pose& T_A_B);

Pose from_position_yaw(const Vec3& position, double yaw_rad);

/// Angle wrapped to [-pi, pi).
double wrap_angle(double angle_rad);

/// Linear in position, slerp in rotation; ratio 0 gives a, 1 gives b.
Pose interpolate(const Pose& a, const Pose& b, double ratio);

/// True when the matrix is finite and its rotation orthonormal within 1e-3 (right-handed).
bool is_valid(const Pose& pose);

}  // namespace voxnav::geometry
