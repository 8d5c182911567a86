// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::graph {

/// The correction of a submap by the graph: from T_O_S, the pose that odometry gave it, to T_W_S.
struct SubmapCorrection {
  base::StampNs start_ns = 0;
  base::StampNs end_ns = 0;
  geometry::Pose T_O_S;
  geometry::Pose T_W_S;  ///< holds for the middle of its time

  base::StampNs middle_ns() const { return start_ns + (end_ns - start_ns) / 2; }
};

/// Corrects a trajectory with the submaps. Between the middles of two submaps a pose is interpolated, in proportion to
/// time, between its corrections by both, so that the result has no steps; before the first middle and after the last
/// one it follows that submap alone. The corrected poses are interpolated and not the corrections, because
/// interpolating rotations about a far origin would bend the trajectory.
/// @param trajectory   poses T_O_B, any order
/// @param corrections  middles strictly rising, at least one
/// @return poses T_W_B with the stamps of the trajectory
/// @throws std::invalid_argument when there is no correction or middles do not rise
/// O(n log k).
std::vector<geometry::StampedPose> correct_trajectory(const std::vector<geometry::StampedPose>& trajectory,
                                                      const std::vector<SubmapCorrection>& corrections);

/// Computes the bends with which the content of each submap moves like the corrected trajectory from which it was seen.
/// @param max_shift_m  largest shift of an end against the middle. A larger one is a jump of odometry and not drift,
/// and
///                     the submap stays rigid on that side.
/// @return one bend for each correction
/// @throws std::invalid_argument if the middles do not rise
std::vector<geometry::Bend> bends_of(const std::vector<SubmapCorrection>& corrections, double max_shift_m);

}  // namespace voxnav::graph
