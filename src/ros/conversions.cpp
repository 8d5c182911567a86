// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/conversions.hpp"

#include "voxnav/geometry/pose.hpp"

namespace voxnav_ros {

using voxnav::geometry::make_pose;
using voxnav::geometry::Pose;
using voxnav::geometry::Vec3;

ros::Time to_ros(voxnav::base::StampNs stamp_ns) {
  ros::Time time;
  if (stamp_ns > 0) time.fromNSec(static_cast<std::uint64_t>(stamp_ns));
  return time;
}

std::string frame_name(const std::string& frame_id) {
  const std::size_t first = frame_id.find_first_not_of('/');
  return first == std::string::npos ? std::string() : frame_id.substr(first);
}

geometry_msgs::Point to_msg(const Vec3& point) {
  geometry_msgs::Point out;
  out.x = point.x();
  out.y = point.y();
  out.z = point.z();
  return out;
}

Vec3 from_msg(const geometry_msgs::Point& point) { return {point.x, point.y, point.z}; }

geometry_msgs::Pose to_msg(const Pose& T_A_B) {
  const Eigen::Quaterniond q(T_A_B.linear());
  geometry_msgs::Pose out;
  out.position = to_msg(Vec3(T_A_B.translation()));
  out.orientation.x = q.x();
  out.orientation.y = q.y();
  out.orientation.z = q.z();
  out.orientation.w = q.w();
  return out;
}

geometry_msgs::Transform to_transform_msg(const Pose& T_A_B) {
  const geometry_msgs::Pose pose = to_msg(T_A_B);
  geometry_msgs::Transform out;
  out.translation.x = pose.position.x;
  out.translation.y = pose.position.y;
  out.translation.z = pose.position.z;
  out.rotation = pose.orientation;
  return out;
}

std::optional<Pose> from_msg(const geometry_msgs::Pose& pose) {
  const auto& q = pose.orientation;
  return make_pose(from_msg(pose.position), Eigen::Quaterniond(q.w, q.x, q.y, q.z));
}

std::optional<Pose> from_msg(const geometry_msgs::Transform& t) {
  return make_pose({t.translation.x, t.translation.y, t.translation.z},
                   Eigen::Quaterniond(t.rotation.w, t.rotation.x, t.rotation.y, t.rotation.z));
}

}  // namespace voxnav_ros
