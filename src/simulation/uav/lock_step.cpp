// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/lock_step.hpp"

#include <algorithm>

namespace voxnav_simulation {

LockStep::LockStep(const std::vector<std::string>& nodes, voxnav::base::StampNs lag_ns) : lag_ns_(lag_ns) {
  for (const std::string& node : nodes) nodes_[node];
}

bool LockStep::report(const std::string& node, voxnav::base::StampNs stamp_ns) {
  const auto it = nodes_.find(node);
  if (it == nodes_.end()) return false;
  const bool was_left_behind = it->second.is_left_behind;
  // A late or repeated report does not take back an earlier one.
  it->second.stamp_ns = std::max(it->second.stamp_ns, stamp_ns);
  it->second.has_reported = true;
  it->second.is_left_behind = false;
  return was_left_behind;
}

std::vector<std::string> LockStep::missing(voxnav::base::StampNs stamp_ns) const {
  std::vector<std::string> out;
  for (const auto& [name, state] : nodes_) {
    if (state.has_reported && !state.is_left_behind && state.stamp_ns < stamp_ns - lag_ns_) out.push_back(name);
  }
  return out;
}

void LockStep::leave_behind(const std::string& node) {
  const auto it = nodes_.find(node);
  if (it != nodes_.end()) it->second.is_left_behind = true;
}

std::vector<std::string> LockStep::unseen() const {
  std::vector<std::string> out;
  for (const auto& [name, state] : nodes_) {
    if (!state.has_reported) out.push_back(name);
  }
  return out;
}

}  // namespace voxnav_simulation
