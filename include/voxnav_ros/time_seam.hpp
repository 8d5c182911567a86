// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/pipeline/time_config.hpp"

namespace voxnav_ros {

/// Seconds for whatever is decided by a duration, an age or a timeout; where they count from means nothing. What is
/// measured for people alone (diagnostics) is wall time and does not come from here. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now_s() const = 0;
  /// To be told of the stamp of every input. Real time goes by itself and takes no notice.
  virtual void reach(const ros::Time& stamp) = 0;
};

/// Real time: never stands still, and never goes back.
class SteadyClock final : public Clock {
 public:
  double now_s() const override;
  void reach(const ros::Time&) override {}
};

/// The time of a simulation that waits for the node (lock-step). It is the newest stamp of any input and stands still
/// in between, so that work takes no time, nothing is late, and what is decided does not depend on the machine. The
/// clock that ROS publishes would not do: its messages may be late themselves. Stamps that are older by up to a second
/// change nothing, because inputs overtake each other; older ones are those of a simulation that began anew.
class InputClock final : public Clock {
 public:
  double now_s() const override;
  void reach(const ros::Time& stamp) override;

 private:
  mutable std::mutex mutex_;
  std::optional<ros::Time> newest_;
};

/// The one place in a nodelet that knows whether time is real or a simulation's that waits for the nodes. Which one is
/// chosen by the section `time` of its parameters; everything else runs the same code on both. Thread-safe.
class TimeSeam {
 public:
  /// Advertises `~progress_out`. @param node name of the ROS node, without its namespace
  TimeSeam(const voxnav::pipeline::TimeConfig& config, std::string node, ros::NodeHandle& private_nh);

  Clock& clock() { return *clock_; }
  /// Everything that the node was sent up to this stamp has been dealt with. Said in real time too: whoever plays a
  /// recording, and a simulated sensor, go by it.
  void report_done(const ros::Time& stamp);
  /// Something of this stamp is about to be sent to the consumers, which report that stamp when they are done with it.
  /// To be called before it is published, so that the simulation cannot go on in between.
  void announce(const ros::Time& stamp);

 private:
  std::string node_;
  std::vector<std::string> awaited_;  ///< nodes to announce work for: none in real time
  std::unique_ptr<Clock> clock_;
  ros::Publisher progress_;
};

}  // namespace voxnav_ros
