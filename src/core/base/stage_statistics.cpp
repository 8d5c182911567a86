// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/stage_statistics.hpp"

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>

namespace voxnav::base {
namespace {

constexpr double kSmallestMs = 1e-3;
const double kLogStep = std::log(1.07);

double now_ms(clockid_t clock) {
  timespec t{};
  clock_gettime(clock, &t);
  return static_cast<double>(t.tv_sec) * 1e3 + static_cast<double>(t.tv_nsec) * 1e-6;
}

}  // namespace

void DurationHistogram::add(double milliseconds) {
  const double clamped = std::max(milliseconds, kSmallestMs);
  const int bucket = std::min(static_cast<int>(std::log(clamped / kSmallestMs) / kLogStep), kBuckets - 1);
  ++buckets_[bucket];
  ++count_;
  sum_ms_ += milliseconds;
  max_ms_ = std::max(max_ms_, milliseconds);
}

double DurationHistogram::quantile_ms(double ratio) const {
  if (count_ == 0) return 0.0;
  const auto wanted = static_cast<std::uint64_t>(std::ceil(ratio * static_cast<double>(count_)));
  std::uint64_t seen = 0;
  for (int bucket = 0; bucket < kBuckets; ++bucket) {
    seen += buckets_[bucket];
    if (seen >= std::max<std::uint64_t>(wanted, 1)) {
      return std::min(max_ms_, kSmallestMs * std::exp(kLogStep * (bucket + 1)));
    }
  }
  return max_ms_;
}

double wall_clock_ms() { return now_ms(CLOCK_MONOTONIC); }
double thread_cpu_ms() { return now_ms(CLOCK_THREAD_CPUTIME_ID); }

StageTimer::StageTimer(StageStatistics* stage)
    : stage_(stage), wall_start_ms_(wall_clock_ms()), cpu_start_ms_(thread_cpu_ms()) {}

StageTimer::~StageTimer() {
  stage_->wall.add(wall_clock_ms() - wall_start_ms_);
  stage_->cpu.add(thread_cpu_ms() - cpu_start_ms_);
}

ProcessUsage process_usage() {
  ProcessUsage usage;
  usage.cpu_s = now_ms(CLOCK_PROCESS_CPUTIME_ID) * 1e-3;
  if (FILE* statm = std::fopen("/proc/self/statm", "r")) {
    unsigned long total = 0;
    unsigned long resident = 0;
    if (std::fscanf(statm, "%lu %lu", &total, &resident) == 2) {
      usage.rss_bytes = static_cast<std::uint64_t>(resident) * static_cast<std::uint64_t>(sysconf(_SC_PAGESIZE));
    }
    std::fclose(statm);
  }
  return usage;
}

}  // namespace voxnav::base
