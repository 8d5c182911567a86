// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/pose_history.hpp"

#include <algorithm>

namespace voxnav_simulation {

using voxnav::base::StampNs;
using voxnav::geometry::Pose;
using voxnav::geometry::StampedPose;

bool PoseHistory::add(const StampedPose& pose) {
  const bool is_back = !poses_.empty() && pose.stamp_ns < poses_.back().stamp_ns;
  if (is_back) poses_.clear();
  if (!poses_.empty() && pose.stamp_ns == poses_.back().stamp_ns) poses_.pop_back();
  poses_.push_back(pose);
  while (poses_.size() > capacity_) poses_.pop_front();
  return !is_back;
}

std::optional<StampNs> PoseHistory::oldest_ns() const {
  if (poses_.empty()) return std::nullopt;
  return poses_.front().stamp_ns;
}

std::optional<StampNs> PoseHistory::newest_ns() const {
  if (poses_.empty()) return std::nullopt;
  return poses_.back().stamp_ns;
}

std::optional<Pose> PoseHistory::at(StampNs stamp_ns) const {
  const auto is_before = [](const StampedPose& pose, StampNs stamp) { return pose.stamp_ns < stamp; };
  const auto after = std::lower_bound(poses_.begin(), poses_.end(), stamp_ns, is_before);
  if (after == poses_.end()) return std::nullopt;
  if (after->stamp_ns == stamp_ns) return after->pose;
  if (after == poses_.begin()) return std::nullopt;
  const StampedPose& before = *(after - 1);
  const double ratio =
      static_cast<double>(stamp_ns - before.stamp_ns) / static_cast<double>(after->stamp_ns - before.stamp_ns);
  return voxnav::geometry::interpolate(before.pose, after->pose, ratio);
}

}  // namespace voxnav_simulation
