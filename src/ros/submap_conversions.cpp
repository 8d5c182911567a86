// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/submap_conversions.hpp"

#include <stdexcept>

#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

using voxnav::submap::SubmapEntry;

voxnav::geometry::Pose valid_pose(const geometry_msgs::Pose& msg, const char* name) {
  const auto pose = from_msg(msg);
  if (!pose) throw std::invalid_argument(std::string(name) + " is not a valid pose");
  return *pose;
}

/// Converts the pose history of Handover and Submap messages.
template <class Msg>
std::vector<voxnav::geometry::StampedPose> pose_history_of(const Msg& msg) {
  if (msg.pose_stamps.size() != msg.T_S_B.size()) throw std::invalid_argument("pose_stamps and T_S_B differ in length");
  std::vector<voxnav::geometry::StampedPose> out;
  for (std::size_t i = 0; i < msg.T_S_B.size(); ++i) {
    out.push_back({to_ns(msg.pose_stamps[i]), valid_pose(msg.T_S_B[i], "T_S_B")});
  }
  return out;
}

}  // namespace

std::vector<voxnav::geometry::Pose> valid_poses(const std::vector<geometry_msgs::Pose>& msgs, const char* name) {
  std::vector<voxnav::geometry::Pose> out;
  out.reserve(msgs.size());
  for (const geometry_msgs::Pose& msg : msgs) out.push_back(valid_pose(msg, name));
  return out;
}

std::vector<voxnav::geometry::Bend> bends_of(const msg::SubmapPoses& msg) {
  std::vector<voxnav::geometry::Bend> out(msg.submap_ids.size());
  if (msg.T_S_begin.empty() && msg.T_S_end.empty()) return out;
  const auto begins = valid_poses(msg.T_S_begin, "T_S_begin");
  const auto ends = valid_poses(msg.T_S_end, "T_S_end");
  if (begins.size() != out.size() || ends.size() != out.size())
    throw std::invalid_argument("submap_ids, T_S_begin and T_S_end differ in length");
  for (std::size_t i = 0; i < out.size(); ++i) out[i] = {begins[i], ends[i]};
  return out;
}

voxnav::pipeline::Handover from_msg(const msg::Handover& msg) {
  voxnav::pipeline::Handover out;
  out.submap_id = msg.submap_id;
  out.is_final = msg.is_final;
  out.reason = msg.reason;
  out.start_ns = to_ns(msg.start);
  out.stamp_ns = to_ns(msg.header.stamp);
  out.T_O_S = valid_pose(msg.T_O_S, "T_O_S");
  out.poses = pose_history_of(msg);
  out.content = voxnav::occupancy::MapContent::from_bytes(std::string(msg.content.begin(), msg.content.end()));
  return out;
}

msg::FinishedSubmap to_msg(const SubmapEntry& entry, const std::string& odometry_frame) {
  msg::FinishedSubmap msg;
  msg.header.frame_id = odometry_frame;
  msg.header.stamp = to_ros(entry.end_ns);
  msg.submap_id = entry.id;
  msg.start = to_ros(entry.start_ns);
  msg.T_O_S = to_msg(entry.T_O_S);
  for (const voxnav::geometry::StampedPose& pose : entry.T_S_B) {
    msg.pose_stamps.push_back(to_ros(pose.stamp_ns));
    msg.T_S_B.push_back(to_msg(pose.pose));
  }
  const std::string bytes = entry.submap->to_bytes();
  msg.data.assign(bytes.begin(), bytes.end());
  return msg;
}

SubmapEntry from_msg(const msg::FinishedSubmap& msg) {
  SubmapEntry entry;
  entry.id = msg.submap_id;
  entry.start_ns = to_ns(msg.start);
  entry.end_ns = to_ns(msg.header.stamp);
  entry.T_O_S = valid_pose(msg.T_O_S, "T_O_S");
  entry.T_W_S = entry.T_O_S;
  entry.T_S_B = pose_history_of(msg);
  entry.submap = voxnav::submap::Submap::from_bytes(std::string(msg.data.begin(), msg.data.end()));
  return entry;
}

}  // namespace voxnav_ros
