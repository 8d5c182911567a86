// SPDX-License-Identifier: BSD-3-Clause
#include "frames.hpp"

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {

using voxnav::geometry::Pose;

UavFrames::UavFrames(const std::string& uav_name, const std::string& estimator)
    : prefix_(uav_name + "/"),
      body_(prefix_ + "fcu"),
      control_(prefix_ + estimator + "_origin"),
      ground_truth_(prefix_ + "ground_truth_origin"),
      listener_(buffer_) {}

std::vector<geometry_msgs::TransformStamped> UavFrames::tree(const voxnav_simulation::Uav& uav,
                                                             const ros::Time& stamp) const {
  std::vector<geometry_msgs::TransformStamped> out;
  const auto add = [&](const std::string& child, const Pose& T_body_child) {
    geometry_msgs::TransformStamped transform;
    transform.header.stamp = stamp;
    transform.header.frame_id = body_;
    transform.child_frame_id = child;
    transform.transform = to_transform_msg(T_body_child);
    out.push_back(transform);
  };
  const Pose T_B_O = uav.estimate().pose.inverse();
  add(control_, T_B_O);
  add(prefix_ + "world_origin", T_B_O);
  add(ground_truth_, uav.truth().pose.inverse());
  const Pose T_O_untilted = voxnav::geometry::gravity_aligned(uav.estimate().pose);
  add(prefix_ + "fcu_untilted", T_B_O * T_O_untilted);
  return out;
}

std::optional<Pose> UavFrames::T_control(const std::string& frame_id) const {
  const std::string full = frame_id.find('/') == std::string::npos ? prefix_ + frame_id : frame_id;
  if (frame_id.empty() || full == control_) return Pose::Identity();
  try {
    return from_msg(buffer_.lookupTransform(control_, full, ros::Time(0)).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

voxnav_simulation::HeadedPoint transformed(const Pose& T_A_B, const voxnav_simulation::HeadedPoint& point_B) {
  const voxnav::geometry::Vec3 direction(std::cos(point_B.heading_rad), std::sin(point_B.heading_rad), 0);
  const voxnav::geometry::Vec3 turned = T_A_B.linear() * direction;
  return {T_A_B * point_B.position, std::atan2(turned.y(), turned.x())};
}

}  // namespace voxnav_ros
