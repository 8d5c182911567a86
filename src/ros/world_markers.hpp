// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "voxnav_simulation/scene.hpp"

namespace voxnav_ros {

/// The world for rviz: one triangle list per surface class (ns "world") and the vehicle (ns "vehicle"), together at
/// most `max_triangles` of the static mesh. Leaves are thinned out before anything else is.
visualization_msgs::MarkerArray world_markers(const voxnav_simulation::Scene& scene, const std::string& frame_id,
                                              std::size_t max_triangles);

}  // namespace voxnav_ros
