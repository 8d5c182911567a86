// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/nodelet_base.hpp"

#include <ros/callback_queue.h>

namespace voxnav_ros {

void NodeletBase::onInit() {
  // Diagnostics and progress use the process' own queue and neither of the two queues of the nodelet. A nodelet that is
  // unloaded while a callback runs ends with that callback, by when its other queue is gone, so that each nodelet has
  // to keep to one of its two.
  ros::NodeHandle nh(getPrivateNodeHandle());
  nh.setCallbackQueue(ros::getGlobalCallbackQueue());
  name_ = getName().substr(getName().rfind('/') + 1);
  diagnostics_ = std::make_unique<Diagnostics>(name_, nh);
  parameters_ = std::make_unique<ParamLoader>(nh);
  voxnav::pipeline::TimeConfig time;
  parameters_->section("time", &time);
  time_ = std::make_unique<TimeSeam>(time, name_, nh);
  try {
    initialize();
  } catch (const std::exception& error) {
    NODELET_FATAL_STREAM("[" << node_ << "]: not started:\n" << error.what());
    throw;  // the manager then reports to whoever asked for the nodelet that loading failed
  }
  const auto begin = [this](const ros::SteadyTimerEvent&) {
    diagnostics_->start();
    start();
    NODELET_INFO_STREAM("[" << node_ << "]: initialized");
  };
  starter_ = ros::NodeHandle().createSteadyTimer(ros::WallDuration(1e-3), begin, true);
}

}  // namespace voxnav_ros
