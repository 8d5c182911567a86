// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav_simulation/trajectory_generator.hpp"

namespace voxnav_simulation {

/// Returns a heading for each of the positions, which are given at every fine step. The headings respect the limits,
/// because a simulated tracker with these limits follows those that the request asks for. The last position is repeated
/// until the heading has been reached.
/// @param waypoint_steps  step at which each of `waypoints` is passed
std::vector<double> heading_profile(const PathRequest& request, const std::vector<HeadedPoint>& waypoints,
                                    const TrackerAxisLimits& limits, const std::vector<std::size_t>& waypoint_steps,
                                    std::vector<Vec3>* positions);

}  // namespace voxnav_simulation
