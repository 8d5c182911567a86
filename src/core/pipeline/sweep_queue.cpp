// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/sweep_queue.hpp"

#include <utility>

namespace voxnav::pipeline {

void SweepSettler::settle(WaitingSweep* waiting) const {
  if (waiting->is_settled()) return;
  SweepLocation found = locator->locate(waiting->sweep, use_deskew ? waiting->sweep.duration_ns : 0);
  if (found.status == SweepLocation::Status::kKnown) {
    waiting->poses = found.poses;
  } else if (found.status == SweepLocation::Status::kNever || has_ended) {
    waiting->drop = WaitingSweep::Drop{SweepFate::kNoPose, "there is no pose for it: " + found.problem};
  }
}

void SweepQueue::push(WaitingSweep waiting) {
  if (!waiting.drop && is_surplus(waiting.sweep.start_ns))
    waiting.drop = WaitingSweep::Drop{SweepFate::kSurplus, "it comes sooner than max_rate_hz allows"};
  waiting_.push_back(std::move(waiting));
}

/// Sweeps are due at even times as long as they come about then, so that the mean rate is the one that is allowed, and
/// stamps that tremble cost nothing.
bool SweepQueue::is_surplus(base::StampNs start_ns) {
  const base::StampNs period_ns = base::from_seconds(1.0 / config_.max_rate_hz);
  const bool is_same_clock = next_due_ns_ && start_ns > *next_due_ns_ - period_ns;
  if (is_same_clock && start_ns < *next_due_ns_ - period_ns / 5) return true;
  const bool is_on_time = is_same_clock && start_ns - *next_due_ns_ < period_ns;
  next_due_ns_ = (is_on_time ? *next_due_ns_ : start_ns) + period_ns;
  return false;
}

void SweepQueue::limit(std::size_t max_without_pose, const SweepSettler& settler) {
  WaitingSweep* oldest = nullptr;
  std::size_t num_without_pose = 0;
  for (WaitingSweep& each : waiting_) {
    settler.settle(&each);
    if (each.is_settled()) continue;
    if (!oldest) oldest = &each;
    ++num_without_pose;
  }
  if (num_without_pose <= max_without_pose) return;
  oldest->drop = WaitingSweep::Drop{SweepFate::kCrowded, "more scans wait for their pose than max_pending_scans"};
}

void SweepQueue::drop_overdue(double now_s, double timeout_s, const SweepSettler& settler) {
  for (WaitingSweep& each : waiting_) {
    settler.settle(&each);
    if (each.is_settled() || now_s - each.since_s <= timeout_s) continue;
    const std::string problem = settler.locator->locate(each.sweep, each.sweep.duration_ns).problem;
    each.drop =
        WaitingSweep::Drop{SweepFate::kNoPose, "no pose within " + std::to_string(timeout_s) + " s: " + problem};
  }
}

void SweepQueue::forget_poses() {
  for (WaitingSweep& each : waiting_) each.poses.reset();
}

WaitingSweep SweepQueue::pop() {
  WaitingSweep out = std::move(waiting_.front());
  waiting_.pop_front();
  return out;
}

}  // namespace voxnav::pipeline
