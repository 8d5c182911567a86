// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/base/clock_watch.hpp"

#include <algorithm>
#include <utility>

namespace voxnav::base {

std::string describe(const StampCounts& counts) {
  std::string out;
  for (const auto& [count, words] : {std::pair{counts.repeated, "repeated"},
                                     {counts.late, "late"},
                                     {counts.stray, "alone on another clock"},
                                     {counts.new_clocks, "from which on the clock was another"}}) {
    if (count > 0) out += (out.empty() ? "" : ", ") + std::to_string(count) + " " + words;
  }
  if (counts.stuck_clocks > 0) {
    out += "; the clock stood still " + std::to_string(counts.stuck_clocks) + " times, for up to " +
           std::to_string(counts.longest_repeat + 1) + " messages";
  }
  return out;
}

StampVerdict ClockWatch::add(StampNs stamp_ns) {
  note_repeat(last_ns_ == stamp_ns);
  last_ns_ = stamp_ns;
  const StampVerdict verdict = judge(stamp_ns);
  std::uint64_t* counts[] = {&counts_.next, &counts_.repeated, &counts_.late, &counts_.stray, &counts_.new_clocks};
  ++*counts[static_cast<std::size_t>(verdict)];
  return verdict;
}

void ClockWatch::reset() {
  newest_ns_ = stray_ns_ = last_ns_ = std::nullopt;
  num_equal_ = 0;
}

StampVerdict ClockWatch::judge(StampNs stamp_ns) {
  const bool is_ahead = newest_ns_ && limits_.max_lead_ns && stamp_ns > *newest_ns_ + *limits_.max_lead_ns;
  const bool is_behind = newest_ns_ && stamp_ns < *newest_ns_ - limits_.max_lag_ns;
  if (is_ahead || is_behind) return judge_stray(stamp_ns);
  stray_ns_.reset();
  if (newest_ns_ && stamp_ns <= *newest_ns_)
    return stamp_ns == *newest_ns_ ? StampVerdict::kRepeated : StampVerdict::kLate;
  newest_ns_ = stamp_ns;
  return StampVerdict::kNext;
}

StampVerdict ClockWatch::judge_stray(StampNs stamp_ns) {
  // A source may be slower than the limit: then stamps ahead follow each other at the distance to the newest stamp.
  const StampNs lead_ns = stamp_ns - *newest_ns_;
  const StampNs max_step_ns = std::max({limits_.max_lag_ns, limits_.max_lead_ns.value_or(0), lead_ns / 2});
  const bool confirms = stray_ns_ && stamp_ns > *stray_ns_ && stamp_ns <= *stray_ns_ + max_step_ns;
  num_stray_ = confirms ? num_stray_ + 1 : 1;
  stray_ns_ = stamp_ns;
  if (num_stray_ < limits_.num_confirming) return StampVerdict::kStray;
  newest_ns_ = stamp_ns;
  stray_ns_.reset();
  return StampVerdict::kNewClock;
}

void ClockWatch::note_repeat(bool is_repeated) {
  num_equal_ = is_repeated ? num_equal_ + 1 : 0;
  counts_.longest_repeat = std::max(counts_.longest_repeat, num_equal_);
  if (num_equal_ + 1 == kNumStuck) ++counts_.stuck_clocks;
}

}  // namespace voxnav::base
