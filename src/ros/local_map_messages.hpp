// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap_msgs/Octomap.h>
#include <sensor_msgs/PointCloud2.h>

#include <vector>

#include "voxnav/Handover.h"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"

namespace voxnav_ros {

voxnav::Handover to_msg(const voxnav::pipeline::Handover& handover, const std::string& odometry_frame);

/// Cloud of one row with the fields x y z float32; `xyz` holds (x, y, z) rows.
sensor_msgs::PointCloud2 cloud_of(const std::vector<float>& xyz, const std_msgs::Header& header);

octomap_msgs::Octomap octomap_of(const voxnav::occupancy::LocalMap& map, bool is_binary,
                                 const std_msgs::Header& header);

}  // namespace voxnav_ros
