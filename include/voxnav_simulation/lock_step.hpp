// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <vector>

#include "voxnav/base/time.hpp"

namespace voxnav_simulation {

/// Decides whether simulated time may go on: every listed node must have dealt with everything up to `lag` ago.
/// A node counts from its first report on, so that nodes may start in any order; one that stays silent for too long
/// (the caller's wall clock decides) is left behind until it reports again. Not thread-safe.
class LockStep {
 public:
  LockStep(const std::vector<std::string>& nodes, voxnav::base::StampNs lag_ns);

  /// @return true when a node that was left behind is back
  bool report(const std::string& node, voxnav::base::StampNs stamp_ns);
  /// Nodes that keep time from reaching `stamp_ns`; empty: go on.
  std::vector<std::string> missing(voxnav::base::StampNs stamp_ns) const;
  /// No longer waits for a node until its next report.
  void leave_behind(const std::string& node);
  /// Listed nodes that never reported.
  std::vector<std::string> unseen() const;
  bool is_empty() const { return nodes_.empty(); }

 private:
  struct State {
    voxnav::base::StampNs stamp_ns = 0;
    bool has_reported = false;
    bool is_left_behind = false;
  };
  std::map<std::string, State> nodes_;
  voxnav::base::StampNs lag_ns_;
};

}  // namespace voxnav_simulation
