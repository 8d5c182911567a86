// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/sweep_scheduler.hpp"

#include <algorithm>

namespace voxnav_simulation {
namespace {

using voxnav::base::StampNs;

constexpr std::size_t kMaxPoses = 4096;          // enough for a turn of 1 s at 1 kHz
constexpr StampNs kMaxTruthGapNs = 100'000'000;  // ten times the interval of true poses, which come at 100 Hz or more

/// Returns the quotient rounded towards plus infinity, for negative numbers too.
std::int64_t ceil_div(std::int64_t a, std::int64_t b) { return a >= 0 ? (a + b - 1) / b : -((-a) / b); }

}  // namespace

SweepScheduler::SweepScheduler(const LidarModel& model, bool is_instantaneous)
    : SweepScheduler(model.sweep_ns(), model.config().T_B_L()) {
  column_times_ns_.assign(static_cast<std::size_t>(model.config().columns), 0);
  if (is_instantaneous) return;
  for (std::size_t i = 0; i < column_times_ns_.size(); ++i)
    column_times_ns_[i] = model.column_time_ns(static_cast<int>(i));
}

SweepScheduler::SweepScheduler(StampNs period_ns, const Pose& T_B_L)
    : period_ns_(period_ns), column_times_ns_{0}, T_B_L_(T_B_L), history_(kMaxPoses) {}

void SweepScheduler::restart() {
  history_ = PoseHistory(kMaxPoses);
  next_index_.reset();
}

void SweepScheduler::add_truth(const voxnav::geometry::StampedPose& T_W_B) {
  if (!voxnav::geometry::is_valid(T_W_B.pose)) {
    ++counts_.poses_refused;
    return;
  }
  const std::optional<StampNs> newest = history_.newest_ns();
  if (newest && T_W_B.stamp_ns > *newest + kMaxTruthGapNs) {
    ++counts_.truth_gaps;
    restart();
  }
  if (!history_.add(T_W_B)) {
    ++counts_.time_jumps;
    next_index_.reset();
  }
  if (!next_index_) next_index_ = ceil_div(T_W_B.stamp_ns, period_ns_);
}

std::optional<SimulatedSweep> SweepScheduler::next() {
  if (!next_index_) return std::nullopt;
  const std::int64_t first_known = ceil_div(history_.oldest_ns().value(), period_ns_);
  next_index_ = std::max(*next_index_, first_known);
  SimulatedSweep sweep;
  sweep.start_ns = *next_index_ * period_ns_;
  sweep.index = static_cast<std::uint64_t>(*next_index_);
  if (sweep.start_ns + column_times_ns_.back() > *history_.newest_ns()) return std::nullopt;
  sweep.T_W_L.reserve(column_times_ns_.size());
  for (const StampNs time_ns : column_times_ns_)
    sweep.T_W_L.push_back(history_.at(sweep.start_ns + time_ns).value() * T_B_L_);
  ++*next_index_;
  return sweep;
}

}  // namespace voxnav_simulation
