// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <optional>

#include "voxnav/cloud/sweep.hpp"

namespace voxnav::odometry {

/// A queue in which sweeps wait, in order, until IMU samples cover them, so that results do not depend on whether a
/// sweep or its samples arrive first. At most kMaxWaiting sweeps wait. Times are those of any clock of the caller.
class ImuGate {
 public:
  static constexpr std::size_t kMaxWaiting = 20;

  struct Limits {
    bool uses_imu = true;        ///< if false, no sweep ever waits
    double imu_timeout_s = 0.5;  ///< an IMU that is silent for so long, or runs on another clock, is not waited for
    double max_wait_s = 0.03;    ///< a sweep waits no longer than this
  };
  explicit ImuGate(const Limits& limits) : limits_(limits) {}

  void note_imu(base::StampNs stamp_ns) { newest_imu_ns_ = stamp_ns; }
  void add(cloud::Sweep sweep, double now_s) { waiting_.push_back({std::move(sweep), now_s}); }
  /// Returns the oldest sweep if it need not wait, must not wait any longer, or too many sweeps wait; else nothing.
  std::optional<cloud::Sweep> next(double now_s);
  /// Returns the oldest sweep in any case.
  std::optional<cloud::Sweep> take_oldest();
  bool empty() const { return waiting_.empty(); }
  void clear() { waiting_.clear(); }

 private:
  struct Waiting {
    cloud::Sweep sweep;
    double since_s;
  };
  bool is_covered(const cloud::Sweep& sweep) const;

  Limits limits_;
  std::optional<base::StampNs> newest_imu_ns_;
  std::deque<Waiting> waiting_;
};

}  // namespace voxnav::odometry
