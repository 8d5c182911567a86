// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>
#include <ros/steady_timer.h>

#include <map>
#include <mutex>
#include <string>

#include "voxnav/NodeDiagnostics.h"
#include "voxnav/base/stage_statistics.hpp"

namespace voxnav_ros {

/// Collects the diagnostics of a node and publishes them once a second of wall time on `~diagnostics_out`, so that they
/// arrive even while the simulated clock stands still. Thread-safe.
class Diagnostics {
 public:
  Diagnostics(const std::string& node, ros::NodeHandle& private_nh);

  /// Starts to publish, once a second of wall time.
  void start() { timer_.start(); }

  /// Measures the wall and CPU time of the caller's scope: `const auto timer = diagnostics.time("insert");`
  class Scope {
   public:
    Scope(Diagnostics* owner, std::string stage);
    ~Scope();
    Scope(const Scope&) = delete;
    Scope& operator=(const Scope&) = delete;

   private:
    Diagnostics* owner_;
    std::string stage_;
    double wall_start_ms_;
    double cpu_start_ms_;
  };
  Scope time(const std::string& stage) { return Scope(this, stage); }

  void add_time(const std::string& stage, double wall_ms, double cpu_ms);
  /// Adds the time from the stamp of the data to now, both in ROS time.
  void add_latency(const std::string& stage, const ros::Time& data_stamp);
  void add_dropped(const std::string& stage, std::uint64_t count = 1);
  void set_counter(const std::string& name, double value);
  /// Sets the level and its message for people. The level OK clears the message.
  void set_level(std::uint8_t level, const std::string& message);

 private:
  void publish(const ros::SteadyTimerEvent&);

  std::mutex mutex_;
  std::string node_;
  std::uint8_t level_ = 0;
  std::string message_;
  std::map<std::string, voxnav::base::StageStatistics> stages_;
  std::map<std::string, double> counters_;
  ros::Publisher publisher_;
  ros::SteadyTimer timer_;
};

}  // namespace voxnav_ros
