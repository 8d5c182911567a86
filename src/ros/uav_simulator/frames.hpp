// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <optional>
#include <string>
#include <vector>

#include "voxnav_simulation/uav.hpp"

namespace voxnav_ros {

/// Names of the simulated vehicle's frames, its inverted tf tree, and references given in other frames.
class UavFrames {
 public:
  UavFrames(const std::string& uav_name, const std::string& estimator);

  const std::string& body() const { return body_; }
  /// The frame of the estimate, in which the vehicle is controlled.
  const std::string& control() const { return control_; }
  const std::string& ground_truth() const { return ground_truth_; }

  /// The inverted tree of the MRS system: fcu is the root, and every origin is its child at the inverse of the
  /// vehicle's pose.
  std::vector<geometry_msgs::TransformStamped> tree(const voxnav_simulation::Uav& uav, const ros::Time& stamp) const;

  /// The transform that takes coordinates in `frame_id` to the control frame, or nothing when tf does not know it now:
  /// nobody waits here. An empty name is the control frame; short names get the vehicle's prefix.
  std::optional<voxnav::geometry::Pose> T_control(const std::string& frame_id) const;

 private:
  std::string prefix_, body_, control_, ground_truth_;
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

/// Returns a reference and heading expressed in another frame.
voxnav_simulation::HeadedPoint transformed(const voxnav::geometry::Pose& T_A_B,
                                           const voxnav_simulation::HeadedPoint& point_B);

}  // namespace voxnav_ros
