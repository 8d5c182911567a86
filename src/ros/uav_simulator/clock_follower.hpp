// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <optional>
#include <string>

#include "voxnav/base/time.hpp"

namespace voxnav_ros {

/// Lets a simulator go with the /clock of another one, and reports to it how far this one has come, so that simulated
/// time waits for both. Only the thread that advances time may block here.
class ClockFollower {
 public:
  /// @param name  under which the other simulator waits for this one
  ClockFollower(ros::NodeHandle& nh, ros::NodeHandle& private_nh, const std::string& name);

  /// Waits for the first time of the clock. Returns nothing after stop().
  std::optional<voxnav::base::StampNs> first();
  /// Waits until the clock has reached a time, or stop() is called.
  void wait(voxnav::base::StampNs stamp_ns);
  void report(voxnav::base::StampNs stamp_ns);
  void stop();

 private:
  std::string name_;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::optional<voxnav::base::StampNs> now_ns_;
  bool is_stopped_ = false;
  ros::Publisher progress_;
  ros::Subscriber clock_;
};

}  // namespace voxnav_ros
