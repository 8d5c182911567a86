// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// Converts a position and a quaternion, as messages carry them, to a pose; nothing if they are not finite, or if the
/// norm of the quaternion is not 1 within 5 %.
std::optional<Pose> make_pose(const Vec3& position, const Eigen::Quaterniond& q);

/// Returns a pose as it arrives when it is sent as position and quaternion. Poses that are handed over within one
/// process are converted as well, so that results are bit by bit the same whether two parts run in one process or as
/// two nodes.
Pose as_sent(const Pose& pose);

}  // namespace voxnav::geometry
