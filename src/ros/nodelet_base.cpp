// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/nodelet_base.hpp"

#include <ros/callback_queue.h>

namespace voxnav_ros {

void NodeletBase::onInit() {
  // On the process' own queue: a nodelet unloaded while a callback runs ends with that callback, and by then its other
  // queue is gone, so that a nodelet must keep to one of its two. What all have in common uses neither.
  ros::NodeHandle nh(getPrivateNodeHandle());
  nh.setCallbackQueue(ros::getGlobalCallbackQueue());
  name_ = getName().substr(getName().rfind('/') + 1);
  diagnostics_ = std::make_unique<Diagnostics>(name_, nh);
  progress_ = nh.advertise<voxnav::Progress>("progress_out", 50);
  try {
    initialize();
  } catch (const std::exception& error) {
    NODELET_FATAL_STREAM("[" << node_ << "]: not started:\n" << error.what());
    throw;  // the manager reports the load as failed, and the launch file sees it
  }
  const auto begin = [this](const ros::SteadyTimerEvent&) {
    diagnostics_->start();
    start();
    NODELET_INFO_STREAM("[" << node_ << "]: initialized");
  };
  starter_ = ros::NodeHandle().createSteadyTimer(ros::WallDuration(1e-3), begin, true);
}

void NodeletBase::publish_progress(const ros::Time& stamp) {
  voxnav::Progress progress;
  progress.node = name_;
  progress.stamp = stamp;
  progress_.publish(progress);
}

void NodeletBase::announce_work(const std::vector<std::string>& nodes, const ros::Time& stamp) {
  for (const std::string& name : nodes) {
    voxnav::Progress progress;
    progress.node = name;
    progress.stamp = stamp;
    progress.is_begun = true;
    progress_.publish(progress);
  }
}

}  // namespace voxnav_ros
