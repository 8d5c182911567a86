// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <visualization_msgs/MarkerArray.h>

#include <string>

#include "voxnav_simulation/scene.hpp"

namespace voxnav_ros {

/// The world for rviz: one triangle list per surface class (namespace "world") and one for the vehicle (namespace
/// "vehicle"). At most `max_triangles` of what never moves are shown; leaves are thinned out before anything else.
visualization_msgs::MarkerArray world_markers(const voxnav_simulation::Scene& scene, const std::string& frame_id,
                                              std::size_t max_triangles);

/// The persons and other UAVs of the world where they are at a time, as cylinders (namespace "movers").
visualization_msgs::MarkerArray mover_markers(const voxnav_simulation::Scene& scene, const std::string& frame_id,
                                              voxnav::base::StampNs stamp_ns);

}  // namespace voxnav_ros
