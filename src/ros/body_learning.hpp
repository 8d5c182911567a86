// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/ControlManagerDiagnostics.h>
#include <ros/ros.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <optional>
#include <string>

#include "voxnav/cloud/body_mask.hpp"

namespace voxnav_ros {

/// The service that learns the UAV's own body from the next clouds. It learns only while the control manager reports
/// that the UAV does not fly, because near returns in flight are obstacles and must never be masked. For one thread.
class BodyLearning {
 public:
  BodyLearning(ros::NodeHandle nh, const voxnav::cloud::BodyMaskConfig& config);
  void start(ros::NodeHandle nh);
  /// Adds the next cloud. @return the mask after the last cloud that is needed, else nothing
  std::optional<voxnav::cloud::BodyMask> add(const voxnav::cloud::RawCloudView& cloud);

 private:
  std::string refusal() const;
  void on_control(const mrs_msgs::ControlManagerDiagnosticsConstPtr& msg);
  bool on_learn(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);

  voxnav::cloud::BodyMaskConfig config_;
  std::unique_ptr<voxnav::cloud::BodyMaskLearner> learner_;  ///< null unless the body is being learnt
  std::string control_topic_;
  bool is_flying_ = false;
  std::optional<ros::SteadyTime> heard_;
  ros::Subscriber control_;
  ros::ServiceServer service_;
};

}  // namespace voxnav_ros
