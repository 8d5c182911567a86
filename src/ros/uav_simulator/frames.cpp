// SPDX-License-Identifier: BSD-3-Clause
#include "frames.hpp"

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {

using voxnav::geometry::Pose;

UavFrames::UavFrames(const std::string& uav_name, const std::string& estimator,
                     const voxnav_simulation::EstimatorSwitchesConfig& second, const voxnav::geometry::Vec3& utm_m)
    : prefix_(uav_name + "/"),
      body_(prefix_ + "fcu"),
      ground_truth_(prefix_ + "ground_truth_origin"),
      estimators_{estimator, second.estimator},
      origins_{prefix_ + estimator + "_origin", prefix_ + second.estimator + "_origin"},
      T_C_O_{Pose::Identity(), Pose::Identity()},
      T_O_utm_(Eigen::Translation3d(-utm_m)),
      listener_(buffer_) {
  Pose T_O_second(Eigen::AngleAxisd(second.offset_heading_rad, voxnav::geometry::Vec3::UnitZ()));
  T_O_second.translation() = voxnav::geometry::Vec3(second.offset_m[0], second.offset_m[1], second.offset_m[2]);
  T_C_O_[1] = T_O_second.inverse();
}

std::string UavFrames::switch_to(const std::string& estimator) {
  if (estimator == estimators_[active_]) return "the estimator " + estimator + " is active already";
  if (estimator != estimators_[1 - active_]) {
    return "there is no estimator " + estimator + ", only " + estimators_[0] + " and " + estimators_[1];
  }
  active_ = 1 - active_;
  ++num_switches_;
  return {};
}

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
  for (std::size_t i = 0; i < origins_.size(); ++i) add(origins_[i], T_B_O * T_C_O_[i].inverse());
  add(prefix_ + "world_origin", T_B_O);
  add(prefix_ + "utm_origin", T_B_O * T_O_utm_);
  add(ground_truth_, uav.truth().pose.inverse());
  const Pose T_O_untilted = voxnav::geometry::gravity_aligned(uav.estimate().pose);
  add(prefix_ + "fcu_untilted", T_B_O * T_O_untilted);
  return out;
}

std::optional<Pose> UavFrames::T_O(const std::string& frame_id) const {
  if (frame_id.empty()) return T_C_O().inverse();
  const std::string full = frame_id.find('/') == std::string::npos ? prefix_ + frame_id : frame_id;
  for (std::size_t i = 0; i < origins_.size(); ++i) {
    if (full == origins_[i]) return T_C_O_[i].inverse();
  }
  try {
    return from_msg(buffer_.lookupTransform(origins_[0], full, ros::Time(0)).transform);
  } catch (const tf2::TransformException&) {
    return std::nullopt;
  }
}

voxnav_simulation::HeadedPoint transformed(const Pose& T_A_B, const voxnav_simulation::HeadedPoint& point_B) {
  const voxnav::geometry::Vec3 direction(std::cos(point_B.heading_rad), std::sin(point_B.heading_rad), 0);
  const voxnav::geometry::Vec3 turned = T_A_B.linear() * direction;
  return {T_A_B * point_B.position, std::atan2(turned.y(), turned.x())};
}

voxnav_simulation::KinematicState transformed(const Pose& T_A_B, const voxnav_simulation::KinematicState& state_B) {
  voxnav_simulation::KinematicState out = state_B;
  const auto point = transformed(T_A_B, voxnav_simulation::HeadedPoint{state_B.position, state_B.heading_rad});
  out.position = point.position;
  out.heading_rad = point.heading_rad;
  for (voxnav::geometry::Vec3* vector : {&out.velocity, &out.acceleration, &out.jerk})
    *vector = T_A_B.linear() * *vector;
  return out;
}

voxnav_simulation::BodyState transformed(const Pose& T_A_B, const voxnav_simulation::BodyState& state_B) {
  voxnav_simulation::BodyState out = state_B;
  out.pose = T_A_B * state_B.pose;
  out.velocity = T_A_B.linear() * state_B.velocity;
  out.acceleration = T_A_B.linear() * state_B.acceleration;
  return out;
}

}  // namespace voxnav_ros
