// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <deque>
#include <optional>
#include <string>

#include "pipeline/sweep_stamps.hpp"
#include "voxnav/pipeline/mapper.hpp"

namespace voxnav::pipeline {

/// A sweep that waits for its poses, has them, or is given up.
struct WaitingSweep {
  struct Drop {
    SweepFate fate;
    std::string reason;
  };
  cloud::Sweep sweep;
  std::optional<SweepPoses> poses;
  double since_s = 0.0;
  std::optional<Drop> drop;

  bool is_settled() const { return poses || drop; }
};

/// Settles sweeps: finds the poses of those that have none, and gives up those that will never have any.
struct SweepSettler {
  const SweepLocator* locator;
  bool use_deskew;
  bool has_ended = false;  ///< no more poses come

  void settle(WaitingSweep* waiting) const;
};

/// The sweeps of one sensor that wait, in the order of their arrival. Sensors do not wait for each other, so that one
/// that fails costs its own sweeps only. Not thread-safe.
class SweepQueue {
 public:
  explicit SweepQueue(const SensorConfig& config) : config_(config) {}

  const SensorConfig& config() const { return config_; }
  SweepStamps& stamps() { return stamps_; }
  /// Adds a sweep; one that comes sooner than max_rate_hz allows is given up.
  void push(WaitingSweep waiting);
  /// Gives up the oldest sweep without poses if there are more of these than `max_without_pose`.
  void limit(std::size_t max_without_pose, const SweepSettler& settler);
  /// Gives up sweeps that have waited longer than `timeout_s` by the time `now_s`.
  void drop_overdue(double now_s, double timeout_s, const SweepSettler& settler);
  /// The frame of all poses changes: they are to be found anew.
  void forget_poses();
  bool empty() const { return waiting_.empty(); }
  std::size_t size() const { return waiting_.size(); }
  WaitingSweep& front() { return waiting_.front(); }
  WaitingSweep pop();

 private:
  bool is_surplus(base::StampNs start_ns);

  SensorConfig config_;
  SweepStamps stamps_;
  std::optional<base::StampNs> next_due_ns_;
  std::deque<WaitingSweep> waiting_;
};

}  // namespace voxnav::pipeline
