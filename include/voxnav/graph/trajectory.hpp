// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::graph {

/// Where the graph moved a submap: from T_O_S, as odometry had it, to T_W_S.
struct SubmapCorrection {
  base::StampNs stamp_ns = 0;  ///< middle of the time the submap covers
  geometry::Pose T_O_S;
  geometry::Pose T_W_S;
};

/// Moves a trajectory with the submaps. Between the middles of two submaps the pose is blended from the corrections of
/// both, in proportion to time, so that the result has no steps; before the first and after the last it follows that
/// one. Blended is the corrected pose, not the correction: a turn about a far origin would bend it.
/// @param trajectory   poses T_O_B, any order
/// @param corrections  stamps strictly rising, at least one
/// @return poses T_W_B with the stamps of the trajectory
/// @throws std::invalid_argument when there is no correction or stamps do not rise
/// O(n log k).
std::vector<geometry::StampedPose> correct_trajectory(const std::vector<geometry::StampedPose>& trajectory,
                                                      const std::vector<SubmapCorrection>& corrections);

}  // namespace voxnav::graph
