// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <geometry_msgs/TransformStamped.h>
#include <ros/time.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <array>
#include <atomic>
#include <optional>
#include <string>
#include <vector>

#include "voxnav_simulation/estimator_switches.hpp"
#include "voxnav_simulation/uav.hpp"

namespace voxnav_ros {

/// Names of the simulated vehicle's frames, its inverted tf tree, its two estimators, and references given in other
/// frames. The vehicle itself knows the origin of its first estimator only, O below; the control frame C is the origin
/// of the active one. Switches may be read and made by any thread.
class UavFrames {
 public:
  /// @param utm_m  UTM coordinates of the origin of O
  UavFrames(const std::string& uav_name, const std::string& estimator,
            const voxnav_simulation::EstimatorSwitchesConfig& second, const voxnav::geometry::Vec3& utm_m);

  const std::string& body() const { return body_; }
  /// The origin of the active estimator, in which the vehicle is controlled.
  const std::string& control() const { return origins_[active_]; }
  const std::string& ground_truth() const { return ground_truth_; }
  const std::string& estimator() const { return estimators_[active_]; }
  std::vector<std::string> estimators() const { return {estimators_.begin(), estimators_.end()}; }
  /// Takes coordinates of O to the control frame.
  const voxnav::geometry::Pose& T_C_O() const { return T_C_O_[active_]; }

  /// Makes an estimator the active one. Returns why that fails, or an empty text.
  std::string switch_to(const std::string& estimator);
  void switch_to_other() { switch_to(estimators_[1 - active_]); }
  std::uint32_t num_switches() const { return num_switches_; }

  /// The inverted tree of the MRS system: fcu is the root, and every origin is its child at the inverse of the
  /// vehicle's pose.
  std::vector<geometry_msgs::TransformStamped> tree(const voxnav_simulation::Uav& uav, const ros::Time& stamp) const;

  /// The transform that takes coordinates in `frame_id` to O, or nothing when tf does not know it now: nobody waits
  /// here. An empty name is the control frame; short names get the vehicle's prefix.
  std::optional<voxnav::geometry::Pose> T_O(const std::string& frame_id) const;

 private:
  std::string prefix_, body_, ground_truth_;
  std::array<std::string, 2> estimators_, origins_;
  std::array<voxnav::geometry::Pose, 2> T_C_O_;
  voxnav::geometry::Pose T_O_utm_;
  std::atomic<std::size_t> active_{0};
  std::atomic<std::uint32_t> num_switches_{0};
  tf2_ros::Buffer buffer_;
  tf2_ros::TransformListener listener_;
};

/// Returns a reference and heading expressed in another frame, whose z axis is vertical, too.
voxnav_simulation::HeadedPoint transformed(const voxnav::geometry::Pose& T_A_B,
                                           const voxnav_simulation::HeadedPoint& point_B);
voxnav_simulation::KinematicState transformed(const voxnav::geometry::Pose& T_A_B,
                                              const voxnav_simulation::KinematicState& state_B);
voxnav_simulation::BodyState transformed(const voxnav::geometry::Pose& T_A_B,
                                         const voxnav_simulation::BodyState& state_B);

}  // namespace voxnav_ros
