// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/geometry/points_view.hpp"

namespace voxnav::pipeline {

/// Motion of the sensor during one sweep.
struct SweepMotion {
  geometry::Pose T_O_L_start = geometry::Pose::Identity();  ///< at time offset 0
  geometry::Pose T_O_L_end = geometry::Pose::Identity();    ///< at time offset duration_ns
  std::uint32_t duration_ns = 0;
};

/// Returns the pose of the sensor halfway through the sweep.
geometry::Pose middle_of(const SweepMotion& motion);

/// Deskews points in place: moves each point from the sensor frame at its own time to the sensor frame halfway through
/// the sweep. The motion is interpolated linearly in position and by slerp in rotation, in kDeskewSteps steps. Points
/// that are not finite stay so. O(points).
/// @param time_offsets_ns  time of each point after the start of the sweep
/// @throws std::invalid_argument if there are not as many times as points
void deskew(const geometry::MutablePointsView& points, const std::vector<std::uint32_t>& time_offsets_ns,
            const SweepMotion& motion);
constexpr int kDeskewSteps = 64;

}  // namespace voxnav::pipeline
