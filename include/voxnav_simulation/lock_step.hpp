// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "voxnav/base/time.hpp"

namespace voxnav_simulation {

/// Decides whether simulated time may go on. Not thread-safe. Three rules:
/// - Every listed node must have dealt with everything up to `lag` before the last barrier; barriers are the multiples
///   of `period` (0: every instant is one). With the LiDAR's period and the length of its sweep, time stands still at
///   the end of each sweep until its cloud has gone all the way, so that every answer comes at that very instant.
///   A node counts from its first report on, so that nodes may start in any order.
/// - Work that was announced (begin) must be done, whoever does it.
/// - The leader, if there is one, says how far time may run; before its first report it does not run at all.
/// Whoever stays silent for too long (the caller's wall clock decides) is left behind until it reports again.
class LockStep {
 public:
  struct Rules {
    std::vector<std::string> nodes;
    voxnav::base::StampNs lag_ns = 0;
    voxnav::base::StampNs period_ns = 0;
    std::string leader;  ///< empty: none
  };
  explicit LockStep(const Rules& rules);

  /// A node has dealt with everything up to this stamp. @return true when it had been left behind and is back
  bool report(const std::string& node, voxnav::base::StampNs stamp_ns);
  /// A node has been sent something that it will report with this stamp. May come after that report.
  void begin(const std::string& node, voxnav::base::StampNs stamp_ns);
  /// The nodes that keep time from reaching `stamp_ns`; time may go on when there are none.
  std::vector<std::string> missing(voxnav::base::StampNs stamp_ns) const;
  /// Time no longer waits for this node until it reports again.
  void leave_behind(const std::string& node);
  /// The listed nodes that have never reported.
  std::vector<std::string> unseen() const;
  /// Returns true if there is a leader that has not reported yet.
  bool is_waiting_for_leader() const { return !leader_.empty() && !has_leader_reported_; }

 private:
  struct NodeState {
    voxnav::base::StampNs stamp_ns = 0;
    bool has_reported = false;
    bool is_left_behind = false;
  };
  voxnav::base::StampNs required(voxnav::base::StampNs stamp_ns) const;

  std::map<std::string, NodeState> nodes_;
  /// Work announced minus work done, by stamp and node. A report may overtake its announcement, so that -1 is a valid
  /// count; one whose announcement never comes is soon forgotten.
  std::map<std::pair<voxnav::base::StampNs, std::string>, int> begun_;
  voxnav::base::StampNs lag_ns_;
  voxnav::base::StampNs period_ns_;
  std::string leader_;
  bool has_leader_reported_ = false;
  bool is_leader_left_behind_ = false;
  voxnav::base::StampNs horizon_ns_ = 0;
};

}  // namespace voxnav_simulation
