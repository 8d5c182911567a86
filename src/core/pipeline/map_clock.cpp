// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/map_clock.hpp"

#include <algorithm>

namespace voxnav::pipeline {
namespace {

/// Another sensor takes over from one that is silent for so long.
constexpr base::StampNs kMaxSilenceNs = 1'000'000'000;

}  // namespace

MapClock::Verdict MapClock::add(std::size_t sensor, base::StampNs start_ns) {
  Verdict verdict = Verdict::kFollows;
  if (newest_ns_ && start_ns < *newest_ns_ - kMaxStampLagNs) {
    if (!is_jump(sensor, start_ns)) return Verdict::kBehindOthers;
    verdict = Verdict::kJumpedBack;
    for (Sensor& each : sensors_) each.is_on_clock = false;
    newest_ns_.reset();
    leader_.reset();
  }
  for (Sensor& each : sensors_) each.behind_since_ns.reset();
  sensors_[sensor].is_on_clock = true;
  newest_ns_ = newest_ns_ ? std::max(*newest_ns_, start_ns) : start_ns;
  return verdict;
}

bool MapClock::is_jump(std::size_t sensor, base::StampNs start_ns) {
  bool is_alone = true;
  for (std::size_t i = 0; i < sensors_.size(); ++i) is_alone = is_alone && (i == sensor || !sensors_[i].is_on_clock);
  if (is_alone) return true;
  std::optional<base::StampNs>& since_ns = sensors_[sensor].behind_since_ns;
  if (!since_ns || start_ns < *since_ns) since_ns = start_ns;
  return start_ns - *since_ns > kMaxSilenceNs;
}

bool MapClock::leads(std::size_t sensor, base::StampNs start_ns) {
  if (leader_ && sensor > *leader_ && start_ns - leader_ns_ <= kMaxSilenceNs) return false;
  leader_ = sensor;
  leader_ns_ = start_ns;
  return true;
}

}  // namespace voxnav::pipeline
