// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planning/path/segment_clearance.hpp"
#include "planning/path/sight.hpp"

namespace voxnav::planning {

/// Makes a polyline cheaper in continuous space: every segment of the result keeps the distance of `clearance` exactly,
/// touches only cells of SightRule::kExactlyClear, and the whole costs no more than the way over the cells that it
/// replaces. Turns are left out, pulled towards the straight line between their neighbours, and cut off at their
/// corners, until that gains less than one part in two thousand or the checks are spent.
class PathShortening {
 public:
  PathShortening(RunGraph* graph, const SegmentClearance* clearance, std::uint64_t max_checks)
      : graph_(*graph), clearance_(*clearance), max_checks_(max_checks) {}

  std::vector<geometry::Vec3> run(const std::vector<geometry::Vec3>& sights);
  /// Cost of a whole path [voxel edges at unit cost]; infinite if it touches cells that have none.
  double cost_of(const std::vector<geometry::Vec3>& path);

 private:
  /// A point of the path with the cost of the segment that leads to it.
  struct Turn {
    geometry::Vec3 point;
    double cost = 0.0;
    int changed = 0;  ///< the last round in which it, or one beside it, was moved, left out or made
  };

  std::optional<double> segment_cost(const geometry::Vec3& from, const geometry::Vec3& to);
  void make_clear(const std::vector<geometry::Vec3>& sights);
  void leave_out();
  bool pull(std::size_t at);
  bool cut_corner(std::size_t at);
  bool replace(std::size_t at, const geometry::Vec3& point);
  void touch(std::size_t at);
  /// Whether a turn or one beside it has changed since it was tried.
  bool is_in_motion(std::size_t at) const { return turns_[at].changed + 1 >= round_; }
  double total() const;
  bool is_spent() const { return clearance_.num_checks() >= max_checks_; }

  RunGraph& graph_;
  const SegmentClearance& clearance_;
  std::uint64_t max_checks_;
  std::vector<Turn> turns_;
  int round_ = 0;
};

}  // namespace voxnav::planning
