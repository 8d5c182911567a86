// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap_msgs/Octomap.h>

#include <cstdint>
#include <utility>
#include <vector>

namespace voxnav_ros {

/// Makes the message of an OctoMap whose nodes are `data`.
inline octomap_msgs::Octomap octomap_message(std::vector<std::int8_t> data, bool is_binary, double resolution_m,
                                             const std_msgs::Header& header) {
  octomap_msgs::Octomap msg;
  msg.header = header;
  msg.binary = is_binary;
  msg.id = "OcTree";
  msg.resolution = resolution_m;
  msg.data = std::move(data);
  return msg;
}

}  // namespace voxnav_ros
