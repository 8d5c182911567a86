// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/pose_buffer.hpp"

#include <algorithm>

namespace voxnav::geometry {

bool PoseBuffer::add(base::StampNs stamp_ns, const Pose& pose) {
  if (!is_valid(pose)) return false;
  const base::StampVerdict verdict = clock_.add(stamp_ns);
  if (verdict == base::StampVerdict::kStray) {
    strays_.push_back({stamp_ns, pose});
    if (strays_.size() >= static_cast<std::size_t>(kLimits.num_confirming)) strays_.erase(strays_.begin());
    return false;
  }
  if (verdict == base::StampVerdict::kNewClock) take_strays();
  strays_.clear();
  const bool is_taken = verdict == base::StampVerdict::kNext || verdict == base::StampVerdict::kNewClock;
  if (is_taken) push({stamp_ns, pose});
  return is_taken;
}

void PoseBuffer::push(const StampedPose& pose) {
  poses_.push_back(pose);
  if (poses_.size() > kMaxPoses) poses_.pop_front();
}

/// The clock has jumped, ahead or back, and those that were alone on it until now are confirmed.
void PoseBuffer::take_strays() {
  while (!poses_.empty() && poses_.back().stamp_ns >= strays_.front().stamp_ns) poses_.pop_back();
  for (const StampedPose& pose : strays_) push(pose);
}

void PoseBuffer::clear() {
  poses_.clear();
  strays_.clear();
  clock_.reset();
}

std::deque<StampedPose>::const_iterator PoseBuffer::not_before(base::StampNs stamp_ns) const {
  return std::lower_bound(poses_.begin(), poses_.end(), stamp_ns,
                          [](const StampedPose& pose, base::StampNs t) { return pose.stamp_ns < t; });
}

std::optional<base::StampNs> PoseBuffer::gap_around(base::StampNs stamp_ns) const {
  const auto after = not_before(stamp_ns);
  if (!max_gap_ns_ || after == poses_.end() || after->stamp_ns == stamp_ns || after == poses_.begin())
    return std::nullopt;
  const base::StampNs apart_ns = after->stamp_ns - std::prev(after)->stamp_ns;
  return apart_ns > *max_gap_ns_ ? std::optional(apart_ns) : std::nullopt;
}

void PoseBuffer::move_frame(const Pose& T_new_old) {
  for (StampedPose& stamped : poses_) stamped.pose = T_new_old * stamped.pose;
  for (StampedPose& stamped : strays_) stamped.pose = T_new_old * stamped.pose;
}

std::optional<Pose> PoseBuffer::at(base::StampNs stamp_ns) const {
  if (gap_around(stamp_ns)) return std::nullopt;
  const auto after = not_before(stamp_ns);
  if (after == poses_.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->pose;
  if (after == poses_.begin()) return std::nullopt;
  const StampedPose& before = *std::prev(after);
  const double ratio =
      static_cast<double>(stamp_ns - before.stamp_ns) / static_cast<double>(after->stamp_ns - before.stamp_ns);
  return interpolate(before.pose, after->pose, ratio);
}

bool PoseBuffer::is_before_all(base::StampNs stamp_ns) const {
  return !poses_.empty() && stamp_ns < poses_.front().stamp_ns;
}

}  // namespace voxnav::geometry
