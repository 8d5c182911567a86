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

/// The clock for all decisions by a duration, an age or a timeout, in seconds from an arbitrary start. Durations that
/// are measured only for people (diagnostics) are wall time and do not use this clock. Thread-safe.
class Clock {
 public:
  virtual ~Clock() = default;
  virtual double now_s() const = 0;
  /// Takes the stamp of an input; to be called for every input. Real time ignores it.
  virtual void reach(const ros::Time& stamp) = 0;
};

/// Real time, which never stands still and never goes back.
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

/// The one place in a nodelet that knows whether time is real or that of a simulation that waits for the nodes. The
/// section `time` of the parameters chooses; all other code is the same on both. Thread-safe.
class TimeSeam {
 public:
  /// Advertises `~progress_out`. @param node name of the ROS node, without its namespace
  TimeSeam(const voxnav::pipeline::TimeConfig& config, std::string node, ros::NodeHandle& private_nh);

  Clock& clock() { return *clock_; }
  /// Reports that all inputs of the node up to this stamp have been processed. This is reported in real time, too,
  /// since players of recordings and the simulated sensor wait for it.
  /// @param part  the part of the node whose inputs these are, if it has several that are waited for separately: it
  ///              reports as NODE/PART
  void report_done(const ros::Time& stamp, const std::string& part = "");
  /// Announces that a message with this stamp is about to be sent to the consumers, which report the stamp when they
  /// are done. To be called before the message is published, so that the simulation cannot go on in between.
  void announce(const ros::Time& stamp);

 private:
  std::string node_;
  std::vector<std::string> awaited_;  ///< nodes for which work is announced; none in real time
  std::unique_ptr<Clock> clock_;
  ros::Publisher progress_;
};

}  // namespace voxnav_ros
