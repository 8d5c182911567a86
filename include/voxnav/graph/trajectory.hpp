// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/bend.hpp"

namespace voxnav::graph {

/// Where the graph moved a submap: from T_O_S, as odometry had it, to T_W_S.
struct SubmapCorrection {
  base::StampNs start_ns = 0;
  base::StampNs end_ns = 0;
  geometry::Pose T_O_S;
  geometry::Pose T_W_S;  ///< holds for the middle of its time

  base::StampNs middle_ns() const { return start_ns + (end_ns - start_ns) / 2; }
};

/// Moves a trajectory with the submaps. Between the middles of two submaps the pose is blended from the corrections of
/// both, in proportion to time, so that the result has no steps; before the first and after the last it follows that
/// one. Blended is the corrected pose, not the correction: a turn about a far origin would bend it.
/// @param trajectory   poses T_O_B, any order
/// @param corrections  middles strictly rising, at least one
/// @return poses T_W_B with the stamps of the trajectory
/// @throws std::invalid_argument when there is no correction or middles do not rise
/// O(n log k).
std::vector<geometry::StampedPose> correct_trajectory(const std::vector<geometry::StampedPose>& trajectory,
                                                      const std::vector<SubmapCorrection>& corrections);

/// The same for what the submaps hold: how each is bent so that what it saw moves with the place it was seen from.
/// @param max_shift_m  between a middle and an end; more is no drift but a jump, on that side of which it stays rigid
/// @return one per correction
/// @throws std::invalid_argument when middles do not rise
std::vector<geometry::Bend> bends_of(const std::vector<SubmapCorrection>& corrections, double max_shift_m);

}  // namespace voxnav::graph
