// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// Pose of a position and a quaternion as messages carry them; nothing when they are not finite, or the quaternion's
/// norm is not 1 within 5 %.
std::optional<Pose> make_pose(const Vec3& position, const Eigen::Quaterniond& q);

/// A pose as it arrives when it is sent as position and quaternion. What is handed over within one process takes the
/// same way, so that results do not depend, to the last bit, on which parts are nodes of their own.
Pose as_sent(const Pose& pose);

}  // namespace voxnav::geometry
