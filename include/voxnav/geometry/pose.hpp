// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <optional>

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

/// Converts a position and a quaternion, as messages carry them, to a pose; nothing if they are not finite, or if the
/// norm of the quaternion is not 1 within 5 %.
std::optional<Pose> make_pose(const Vec3& position, const Eigen::Quaterniond& q);

/// Returns a pose as it arrives when it is sent as position and quaternion. Poses that are handed over within one
/// process are converted as well, so that results are bit by bit the same whether two parts run in one process or as
/// two nodes.
Pose as_sent(const Pose& pose);

/// The drift within a submap while it was made. The pose of a submap holds for the middle of its time. What it observed
/// at its beginning has to be moved by T_S_begin to lie where it would lie without drift against the middle, what it
/// observed at its end by T_S_end, and what it observed in between by an interpolation. With identities the submap is
/// rigid. docs/maths/submaps.md, section Bend, has the formula.
struct Bend {
  Pose T_S_begin = Pose::Identity();
  Pose T_S_end = Pose::Identity();

  bool is_rigid() const {
    return T_S_begin.matrix() == Pose::Identity().matrix() && T_S_end.matrix() == Pose::Identity().matrix();
  }
  /// Returns the motion at a phase. @param phase  0 at the submap's beginning, 1 at its end
  Pose at(double phase) const;
};

}  // namespace voxnav::geometry
