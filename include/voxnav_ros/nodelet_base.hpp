// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nodelet/nodelet.h>
#include <ros/ros.h>

#include <memory>
#include <string>

#include "voxnav/Progress.h"
#include "voxnav/base/config.hpp"
#include "voxnav_ros/diagnostics.hpp"
#include "voxnav_ros/param_loader.hpp"

namespace voxnav_ros {

/// What every nodelet of voxnav does the same way: strict parameters, diagnostics, progress.
/// A nodelet with unusable parameters logs every problem and is not loaded.
class NodeletBase : public nodelet::Nodelet {
 protected:
  /// @param node  class name, the prefix of log lines (as MRS nodes have it)
  explicit NodeletBase(std::string node) : node_(std::move(node)) {}

  /// Load parameters, build the core object, advertise.
  /// @throws voxnav::base::ConfigError
  virtual void initialize() = 0;
  /// Subscribe and start timers. Comes from the process' own queue once loading has ended: nodelet 1.10.0 loses every
  /// callback that falls due while a nodelet is loaded, and with it the timer for ever
  /// (https://github.com/ros/nodelet_core/issues/106).
  virtual void start() {}

  Diagnostics& diagnostics() { return *diagnostics_; }
  const std::string& node() const { return node_; }
  /// Tells the lock-step simulation that everything up to this stamp has been dealt with.
  void publish_progress(const ros::Time& stamp);
  /// Tells it that these nodes are about to be sent something, and will report this stamp when they are done with it.
  void announce_work(const std::vector<std::string>& nodes, const ros::Time& stamp);

 private:
  void onInit() final;

  std::string node_;
  std::string name_;  ///< of the ROS node, without its namespace: who diagnostics and progress speak for
  std::unique_ptr<Diagnostics> diagnostics_;
  ros::Publisher progress_;
  ros::SteadyTimer starter_;
};

}  // namespace voxnav_ros
