// SPDX-License-Identifier: BSD-3-Clause
#include "clock_follower.hpp"

#include <rosgraph_msgs/Clock.h>

#include <algorithm>

#include "voxnav/Progress.h"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

ClockFollower::ClockFollower(ros::NodeHandle& nh, ros::NodeHandle& private_nh, const std::string& name)
    : name_(name), progress_(private_nh.advertise<msg::Progress>("leader_progress_out", 100)) {
  const boost::function<void(const rosgraph_msgs::ClockConstPtr&)> take =
      [this](const rosgraph_msgs::ClockConstPtr& m) {
        const std::lock_guard<std::mutex> lock(mutex_);
        now_ns_ = std::max(now_ns_.value_or(0), to_ns(m->clock));
        changed_.notify_all();
      };
  clock_ =
      nh.subscribe<rosgraph_msgs::Clock>("/clock", 100, take, ros::VoidConstPtr(), ros::TransportHints().tcpNoDelay());
}

std::optional<voxnav::base::StampNs> ClockFollower::first() {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [this] { return is_stopped_ || now_ns_; });
  return is_stopped_ ? std::nullopt : now_ns_;
}

void ClockFollower::wait(voxnav::base::StampNs stamp_ns) {
  std::unique_lock<std::mutex> lock(mutex_);
  changed_.wait(lock, [&] { return is_stopped_ || (now_ns_ && *now_ns_ >= stamp_ns); });
}

void ClockFollower::report(voxnav::base::StampNs stamp_ns) {
  msg::Progress progress;
  progress.node = name_;
  progress.stamp = to_ros(stamp_ns);
  progress_.publish(progress);
}

void ClockFollower::stop() {
  const std::lock_guard<std::mutex> lock(mutex_);
  is_stopped_ = true;
  changed_.notify_all();
}

}  // namespace voxnav_ros
