// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap_msgs/Octomap.h>

#include <string>

#include "voxnav/Handover.h"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

msg::Handover to_msg(const voxnav::pipeline::Handover& handover, const std::string& odometry_frame);

octomap_msgs::Octomap octomap_of(const voxnav::occupancy::LocalMap& map, bool is_binary,
                                 const std_msgs::Header& header);

}  // namespace voxnav_ros
