// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "voxnav/base/time.hpp"

namespace voxnav_simulation {

/// Decides whether simulated time may advance. Not thread-safe. It follows three rules:
/// - Every listed node must have processed everything up to `lag` before the last barrier. Barriers are the multiples
///   of `period`; with a period of 0 every instant is one. If period and lag are those of the LiDAR's sweeps, time
///   stands still at the end of each sweep until all nodes have processed its cloud, so that their results always
///   appear at that instant. A node counts from its first report on, so that nodes may start in any order.
/// - Work that was announced by begin() must be done, by listed nodes and others alike.
/// - The leader, if there is one, sets how far time may run. Time does not run before the leader's first report.
/// A node that stays silent for too long, by the caller's wall clock, is left behind: time does not wait for it until
/// it reports again.
class LockStep {
 public:
  struct Rules {
    std::vector<std::string> nodes;
    voxnav::base::StampNs lag_ns = 0;
    voxnav::base::StampNs period_ns = 0;
    std::string leader;  ///< empty: none
  };
  explicit LockStep(const Rules& rules);

  /// Records that a node has processed everything up to this stamp.
  /// @return true if the node had been left behind and time waits for it again
  bool report(const std::string& node, voxnav::base::StampNs stamp_ns);
  /// Records that a node was sent a message and will report this stamp once it has processed it. The report may arrive
  /// before this call.
  void begin(const std::string& node, voxnav::base::StampNs stamp_ns);
  /// Returns the nodes that keep time from reaching `stamp_ns`; time may advance if there are none.
  std::vector<std::string> missing(voxnav::base::StampNs stamp_ns) const;
  /// Stops waiting for this node until it reports again.
  void leave_behind(const std::string& node);
  /// Returns the listed nodes that have never reported.
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
  /// The announcements minus the reports, by stamp and node. A report may arrive before its announcement, so that the
  /// count may be -1; only the newest kMaxBegun counts are kept, as some announcements never come.
  std::map<std::pair<voxnav::base::StampNs, std::string>, int> begun_;
  voxnav::base::StampNs lag_ns_;
  voxnav::base::StampNs period_ns_;
  std::string leader_;
  bool has_leader_reported_ = false;
  bool is_leader_left_behind_ = false;
  voxnav::base::StampNs horizon_ns_ = 0;
};

}  // namespace voxnav_simulation
