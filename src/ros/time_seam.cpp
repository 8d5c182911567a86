// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/time_seam.hpp"

#include <utility>

#include "voxnav/Progress.h"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

/// Inputs that come on different topics overtake each other by less than this.
constexpr double kMaxDisorder_s = 1.0;

}  // namespace

double SteadyClock::now_s() const { return ros::SteadyTime::now().toSec(); }

double InputClock::now_s() const {
  const std::lock_guard<std::mutex> lock(mutex_);
  return newest_ ? newest_->toSec() : 0.0;
}

void InputClock::reach(const ros::Time& stamp) {
  const std::lock_guard<std::mutex> lock(mutex_);
  if (!newest_ || stamp > *newest_ || (*newest_ - stamp).toSec() > kMaxDisorder_s) newest_ = stamp;
}

TimeSeam::TimeSeam(const voxnav::pipeline::TimeConfig& config, std::string node, ros::NodeHandle& private_nh)
    : node_(std::move(node)), progress_(private_nh.advertise<msg::Progress>("progress_out", 50)) {
  if (config.waits_for_simulation) {
    clock_ = std::make_unique<InputClock>();
    awaited_ = config.consumers;
  } else {
    clock_ = std::make_unique<SteadyClock>();
  }
}

void TimeSeam::report_done(const ros::Time& stamp, const std::string& part) {
  msg::Progress progress;
  progress.node = part.empty() ? node_ : node_ + "/" + part;
  progress.stamp = stamp;
  progress_.publish(progress);
}

void TimeSeam::announce(const ros::Time& stamp) {
  for (const std::string& name : awaited_) {
    msg::Progress progress;
    progress.node = name;
    progress.stamp = stamp;
    progress.is_begun = true;
    progress_.publish(progress);
  }
}

}  // namespace voxnav_ros
