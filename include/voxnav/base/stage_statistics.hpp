// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace voxnav::base {

/// Mean, maximum and quantiles of a duration in constant memory: a histogram whose buckets are 7 % wide and reach from
/// 1 microsecond to about 500 seconds. A quantile is therefore exact within 7 %.
class DurationHistogram {
 public:
  void add(double milliseconds);
  std::uint64_t count() const { return count_; }
  double mean_ms() const { return count_ == 0 ? 0.0 : sum_ms_ / static_cast<double>(count_); }
  double max_ms() const { return max_ms_; }
  /// @param ratio in [0, 1], 0.99 for the p99; 0 without samples
  double quantile_ms(double ratio) const;

 private:
  static constexpr int kBuckets = 300;
  std::array<std::uint32_t, kBuckets> buckets_{};
  std::uint64_t count_ = 0;
  double sum_ms_ = 0.0;
  double max_ms_ = 0.0;
};

/// The cost of one stage of a node, with the numbers of diagnostics and of metrics.json. Not thread-safe.
struct StageStatistics {
  DurationHistogram wall;
  DurationHistogram cpu;
  DurationHistogram latency;
  std::uint64_t dropped = 0;
};

/// Adds the wall and CPU time (of the calling thread) of its own lifetime to a stage.
class StageTimer {
 public:
  explicit StageTimer(StageStatistics* stage);
  ~StageTimer();
  StageTimer(const StageTimer&) = delete;
  StageTimer& operator=(const StageTimer&) = delete;

 private:
  StageStatistics* stage_;
  double wall_start_ms_;
  double cpu_start_ms_;
};

/// Milliseconds of a monotonic clock, and of the calling thread's CPU time; only differences mean anything.
double wall_clock_ms();
double thread_cpu_ms();

/// Resident memory and CPU time of this process; both are zero on systems that do not tell (all but Linux).
struct ProcessUsage {
  std::uint64_t rss_bytes = 0;
  double cpu_s = 0.0;
};
ProcessUsage process_usage();

}  // namespace voxnav::base
