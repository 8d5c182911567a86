// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <std_msgs/Header.h>
#include <visualization_msgs/MarkerArray.h>

#include <vector>

#include "voxnav/containers/moving_thing.hpp"

namespace voxnav_ros {

/// What moves, for rviz: a cylinder where each thing is (namespace "moving") and an arrow to where it will be in a
/// second (namespace "velocity"). The first marker removes those of the message before.
visualization_msgs::MarkerArray moving_markers(const std::vector<voxnav::containers::MovingThing>& things,
                                               const std_msgs::Header& header);

}  // namespace voxnav_ros
