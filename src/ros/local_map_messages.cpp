// SPDX-License-Identifier: BSD-3-Clause
#include "local_map_messages.hpp"

#include "voxnav/occupancy/octomap_export.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/octomap_messages.hpp"

namespace voxnav_ros {

msg::Handover to_msg(const voxnav::pipeline::Handover& handover, const std::string& odometry_frame) {
  msg::Handover msg;
  msg.header.frame_id = odometry_frame;
  msg.header.stamp = to_ros(handover.stamp_ns);
  msg.submap_id = handover.submap_id;
  msg.is_final = handover.is_final;
  msg.reason = handover.reason;
  msg.start = to_ros(handover.start_ns);
  msg.T_O_S = to_msg(handover.T_O_S);
  for (const auto& pose : handover.poses) {
    msg.pose_stamps.push_back(to_ros(pose.stamp_ns));
    msg.T_S_B.push_back(to_msg(pose.pose));
  }
  const std::string bytes = handover.content.to_bytes();
  msg.content.assign(bytes.begin(), bytes.end());
  return msg;
}

octomap_msgs::Octomap octomap_of(const voxnav::occupancy::LocalMap& map, bool is_binary,
                                 const std_msgs::Header& header) {
  return octomap_message(voxnav::occupancy::octomap_message_data(map, is_binary), is_binary, map.config().resolution_m,
                         header);
}

}  // namespace voxnav_ros
