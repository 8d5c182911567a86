// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/lock_step.hpp"

#include <algorithm>

namespace voxnav_simulation {
namespace {

using voxnav::base::StampNs;

/// The number of counts that are kept: far more than there are reports that arrive before their announcements.
constexpr std::size_t kMaxBegun = 1000;

}  // namespace

LockStep::LockStep(const Rules& rules) : lag_ns_(rules.lag_ns), period_ns_(rules.period_ns), leader_(rules.leader) {
  for (const std::string& node : rules.nodes) nodes_[node];
}

bool LockStep::report(const std::string& node, StampNs stamp_ns) {
  if (!leader_.empty() && node == leader_) {
    const bool is_back = is_leader_left_behind_;
    horizon_ns_ = std::max(horizon_ns_, stamp_ns);
    has_leader_reported_ = true;
    is_leader_left_behind_ = false;
    return is_back;
  }
  const auto it = nodes_.find(node);
  if (it == nodes_.end()) {
    if (--begun_[{stamp_ns, node}] == 0) begun_.erase({stamp_ns, node});
    if (begun_.size() > kMaxBegun) begun_.erase(begun_.begin());
    return false;
  }
  const bool was_left_behind = it->second.is_left_behind;
  // A report that arrives late or twice must not move the stamp back.
  it->second.stamp_ns = std::max(it->second.stamp_ns, stamp_ns);
  it->second.has_reported = true;
  it->second.is_left_behind = false;
  return was_left_behind;
}

void LockStep::begin(const std::string& node, StampNs stamp_ns) {
  if (++begun_[{stamp_ns, node}] == 0) begun_.erase({stamp_ns, node});
}

StampNs LockStep::required(StampNs stamp_ns) const {
  const StampNs barrier_ns = period_ns_ > 0 ? (stamp_ns - 1) / period_ns_ * period_ns_ : stamp_ns;
  return barrier_ns - lag_ns_;
}

std::vector<std::string> LockStep::missing(StampNs stamp_ns) const {
  std::vector<std::string> out;
  for (const auto& [name, state] : nodes_) {
    if (state.has_reported && !state.is_left_behind && state.stamp_ns < required(stamp_ns)) out.push_back(name);
  }
  for (const auto& [key, count] : begun_) {
    if (count > 0) out.push_back(key.second);
  }
  const bool holds = !has_leader_reported_ || horizon_ns_ < stamp_ns;
  if (!leader_.empty() && !is_leader_left_behind_ && holds) out.push_back(leader_);
  return out;
}

void LockStep::leave_behind(const std::string& node) {
  if (!leader_.empty() && node == leader_) is_leader_left_behind_ = true;
  const auto it = nodes_.find(node);
  if (it != nodes_.end()) it->second.is_left_behind = true;
  for (auto item = begun_.begin(); item != begun_.end();) {
    item = item->first.second == node ? begun_.erase(item) : std::next(item);
  }
}

std::vector<std::string> LockStep::unseen() const {
  std::vector<std::string> out;
  for (const auto& [name, state] : nodes_) {
    if (!state.has_reported) out.push_back(name);
  }
  return out;
}

}  // namespace voxnav_simulation
