// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <memory>
#include <string>

#include "voxnav/base/config.hpp"
#include "voxnav_ros/diagnostics.hpp"
#include "voxnav_ros/param_loader.hpp"
#include "voxnav_ros/time_seam.hpp"

namespace voxnav_ros {

/// Base class of all nodelets, with the parts that they share: strict parameters, diagnostics, time.
/// A nodelet with unusable parameters logs every problem and is not loaded.
class NodeletBase : public nodelet::Nodelet {
 protected:
  /// @param node  class name, the prefix of log lines (as MRS nodes have it)
  explicit NodeletBase(std::string node) : node_(std::move(node)) {}

  /// Loads the parameters, builds the core object and advertises.
  /// @throws voxnav::base::ConfigError
  virtual void initialize() = 0;
  /// Subscribes and starts timers. It is called from the process' own queue once loading has ended, because nodelet
  /// 1.10.0 loses every callback that falls due while a nodelet is loaded, and with it the timer for ever
  /// (https://github.com/ros/nodelet_core/issues/106).
  virtual void start() {}

  /// The node's parameters, for initialize(), which reads its sections and calls finish(). The section `time` has been
  /// read already.
  ParamLoader& parameters() { return *parameters_; }
  Diagnostics& diagnostics() { return *diagnostics_; }
  Clock& clock() { return time_->clock(); }
  const std::string& node() const { return node_; }
  /// See TimeSeam::report_done().
  void publish_progress(const ros::Time& stamp, const std::string& part = "") { time_->report_done(stamp, part); }
  /// See TimeSeam::announce().
  void announce_work(const ros::Time& stamp) { time_->announce(stamp); }

 private:
  void onInit() final;

  std::string node_;
  std::string name_;  ///< name of the ROS node without its namespace, under which it reports
  std::unique_ptr<ParamLoader> parameters_;
  std::unique_ptr<Diagnostics> diagnostics_;
  std::unique_ptr<TimeSeam> time_;
  ros::SteadyTimer starter_;
};

}  // namespace voxnav_ros
