// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/odometry/imu_gate.hpp"

#include <utility>

namespace voxnav::odometry {

bool ImuGate::is_covered(const cloud::Sweep& sweep) const {
  if (!limits_.uses_imu || !newest_imu_ns_) return true;
  const base::StampNs missing_ns = sweep.start_ns + base::StampNs{sweep.duration_ns} - *newest_imu_ns_;
  return missing_ns <= 0 || missing_ns > base::from_seconds(limits_.imu_timeout_s);
}

std::optional<cloud::Sweep> ImuGate::next(double now_s) {
  if (waiting_.empty()) return std::nullopt;
  const bool is_overdue = now_s - waiting_.front().since_s > limits_.max_wait_s || waiting_.size() > kMaxWaiting;
  if (!is_overdue && !is_covered(waiting_.front().sweep)) return std::nullopt;
  return take_oldest();
}

std::optional<cloud::Sweep> ImuGate::take_oldest() {
  if (waiting_.empty()) return std::nullopt;
  std::optional<cloud::Sweep> out = std::move(waiting_.front().sweep);
  waiting_.pop_front();
  return out;
}

}  // namespace voxnav::odometry
