// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav_simulation/trajectory_generator.hpp"

namespace voxnav_simulation {

/// Headings for positions given every fine step, within the heading limits: a tracker with these limits follows the
/// headings that the request wants. The last position is repeated until the heading has arrived.
/// @param waypoint_steps  step at which each of `waypoints` is passed
std::vector<double> heading_profile(const PathRequest& request, const std::vector<HeadedPoint>& waypoints,
                                    const TrackerAxisLimits& limits, const std::vector<std::size_t>& waypoint_steps,
                                    std::vector<Vec3>* positions);

}  // namespace voxnav_simulation
