// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/ros.h>
#include <tf2/buffer_core.h>
#include <tf2_msgs/TFMessage.h>

#include <functional>
#include <optional>
#include <string>

#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav_ros {

/// Locates sweeps by tf. Transforms are received on the queue of the node handle, so that a mapper that waits for poses
/// is called when there are new ones, and needs neither a thread nor polling.
class TfLocator final : public voxnav::pipeline::SweepLocator {
 public:
  TfLocator(std::string odometry_frame, std::string body_frame);

  /// @param on_change  called after each message with transforms
  void start(ros::NodeHandle& nh, std::function<void()> on_change);
  voxnav::pipeline::SweepLocation locate(const voxnav::cloud::Sweep& sweep, std::uint32_t duration_ns) const override;
  /// Gives all further poses in another frame. While it is empty, sweeps wait.
  void set_odometry_frame(std::string frame) { odometry_frame_ = std::move(frame); }
  /// Returns the newest T_A_B between two frames that is no older than the stamp by more than a second.
  std::optional<voxnav::geometry::Pose> between(const std::string& a, const std::string& b,
                                                const ros::Time& stamp) const;
  /// Returns the newest T_B_L of a sensor; nothing while it is unknown.
  std::optional<voxnav::geometry::Pose> mount(const std::string& sensor_frame) const;

 private:
  using Location = voxnav::pipeline::SweepLocation;
  void take(const tf2_msgs::TFMessage& msg, bool is_static);
  std::optional<voxnav::geometry::Pose> lookup(const std::string& frame, voxnav::base::StampNs stamp_ns,
                                               Location* location) const;
  bool has_newer(const std::string& frame, const ros::Time& stamp) const;

  std::string odometry_frame_, body_frame_;
  tf2::BufferCore buffer_;
  std::function<void()> on_change_;
  ros::Time newest_;
  ros::Subscriber dynamic_, static_;
};

}  // namespace voxnav_ros
