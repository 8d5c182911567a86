// SPDX-License-Identifier: BSD-3-Clause
#include "base/clock_watch.hpp"

namespace voxnav::base {

ClockWatch::Verdict ClockWatch::add(StampNs stamp_ns) {
  const bool is_ahead = newest_ns_ && limits_.max_lead_ns && stamp_ns > *newest_ns_ + *limits_.max_lead_ns;
  const bool is_behind = newest_ns_ && stamp_ns < *newest_ns_ - limits_.max_lag_ns;
  if (is_ahead || is_behind) return add_stray(stamp_ns);
  stray_ns_.reset();
  if (newest_ns_ && stamp_ns <= *newest_ns_) return Verdict::kLate;
  newest_ns_ = stamp_ns;
  return Verdict::kNext;
}

ClockWatch::Verdict ClockWatch::add_stray(StampNs stamp_ns) {
  const bool confirms = stray_ns_ && stamp_ns > *stray_ns_ && stamp_ns <= *stray_ns_ + limits_.max_lag_ns;
  num_stray_ = confirms ? num_stray_ + 1 : 1;
  stray_ns_ = stamp_ns;
  if (num_stray_ < limits_.num_confirming) return Verdict::kStray;
  newest_ns_ = stamp_ns;
  stray_ns_.reset();
  return Verdict::kNewClock;
}

}  // namespace voxnav::base
