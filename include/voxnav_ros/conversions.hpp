// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/Pose.h>
#include <geometry_msgs/Transform.h>
#include <ros/time.h>

#include <optional>
#include <string>

#include "voxnav/base/time.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav_ros {

inline voxnav::base::StampNs to_ns(const ros::Time& time) { return static_cast<voxnav::base::StampNs>(time.toNSec()); }
/// The stamp as ROS has it. ROS cannot hold stamps before 1970, which become zero.
ros::Time to_ros(voxnav::base::StampNs stamp_ns);

/// A frame id as tf2 has it: without the leading slash that drivers of the first tf put before it.
std::string frame_name(const std::string& frame_id);

geometry_msgs::Point to_msg(const voxnav::geometry::Vec3& point);
voxnav::geometry::Vec3 from_msg(const geometry_msgs::Point& point);

geometry_msgs::Pose to_msg(const voxnav::geometry::Pose& T_A_B);
geometry_msgs::Transform to_transform_msg(const voxnav::geometry::Pose& T_A_B);

/// The pose of a message, or nothing when it holds values that are not finite or a quaternion whose length is far from
/// one. A quaternion whose length is nearly one is normalised.
std::optional<voxnav::geometry::Pose> from_msg(const geometry_msgs::Pose& pose);
std::optional<voxnav::geometry::Pose> from_msg(const geometry_msgs::Transform& transform);

}  // namespace voxnav_ros
