// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_map>
#include <vector>

#include "voxnav/planning/clearance_field.hpp"

namespace voxnav::test {

/// Lazy Theta* on single cells, straight from the paper: a yardstick for planners, without their tricks. Cells are
/// flyable or not; lines of sight pass flyable cells only and cut no corner. Source: Nash, Koenig & Tovey, Lazy Theta*,
/// AAAI 2010, figure 5.
class LazyThetaStar {
 public:
  using Index3 = geometry::Index3;
  using Vec3 = geometry::Vec3;

  /// @param field  field whose labels tell what is flyable; must outlive the search
  explicit LazyThetaStar(const planning::ClearanceField* field) : field_(*field) {}

  /// Returns the centres of the cells at which the path turns; empty if there is no path.
  std::vector<Vec3> plan(const Vec3& start, const Vec3& goal) {
    const double v = field_.resolution_m();
    start_ = geometry::index_of(start, v);
    goal_ = geometry::index_of(goal, v);
    nodes_.clear();
    nodes_[start_] = {start_, 0.0, false};
    open_ = {};
    open_.push({distance(start_, goal_), start_});
    while (!open_.empty()) {
      const Index3 cell = open_.top().second;
      open_.pop();
      if (nodes_[cell].is_closed) continue;
      set_vertex(cell);
      nodes_[cell].is_closed = true;
      ++num_expansions;
      if (cell == goal_) return trace();
      expand(cell);
    }
    return {};
  }

  std::uint64_t num_expansions = 0;

 private:
  struct Node {
    Index3 parent;
    double cost = 1e300;
    bool is_closed = false;
  };
  using Entry = std::pair<double, Index3>;

  static double distance(const Index3& a, const Index3& b) {
    return std::sqrt(std::pow(a.x - b.x, 2) + std::pow(a.y - b.y, 2) + std::pow(a.z - b.z, 2));
  }
  bool is_flyable(const Index3& cell) const {
    return field_.component(geometry::center_of(cell, field_.resolution_m())) != 0;
  }
  /// True if all cells are flyable that a line between two centres touches, edges and corners included.
  bool sees(const Index3& a, const Index3& b) const {
    const Index3 d = b - a;
    const std::array<int, 3> length = {std::abs(d.x), std::abs(d.y), std::abs(d.z)};
    const std::array<int, 3> step = {(d.x > 0) - (d.x < 0), (d.y > 0) - (d.y < 0), (d.z > 0) - (d.z < 0)};
    std::array<int, 3> done = {0, 0, 0};
    Index3 at = a;
    while (at != b) {
      // The next boundary on axis k lies at (2 done + 1) / (2 length) of the line: compared without division.
      double next = 2.0;
      for (int k = 0; k < 3; ++k) {
        if (done[k] < length[k]) next = std::min(next, (2.0 * done[k] + 1.0) / (2.0 * length[k]));
      }
      int axes = 0;
      for (int k = 0; k < 3; ++k) {
        if (done[k] < length[k] && (2.0 * done[k] + 1.0) / (2.0 * length[k]) < next + 1e-9) axes |= 1 << k;
      }
      for (int subset = axes; subset > 0; subset = (subset - 1) & axes) {
        const Index3 side =
            at + Index3{(subset & 1) ? step[0] : 0, (subset & 2) ? step[1] : 0, (subset & 4) ? step[2] : 0};
        if (!is_flyable(side)) return false;
      }
      for (int k = 0; k < 3; ++k) done[k] += (axes >> k) & 1;
      at = a + Index3{step[0] * done[0], step[1] * done[1], step[2] * done[2]};
    }
    return true;
  }

  template <class Fn>
  void for_each_neighbour(const Index3& cell, Fn fn) {
    for (int move = 0; move < 27; ++move) {
      const Index3 next = cell + Index3{move % 3 - 1, move / 3 % 3 - 1, move / 9 - 1};
      if (move != 13 && sees(cell, next)) fn(next);
    }
  }

  void set_vertex(const Index3& cell) {
    if (cell == start_ || sees(nodes_[cell].parent, cell)) return;
    Node best{cell, 1e300, false};
    for_each_neighbour(cell, [&](const Index3& next) {
      const auto found = nodes_.find(next);
      if (found == nodes_.end() || !found->second.is_closed) return;
      const double cost = found->second.cost + distance(next, cell);
      if (cost < best.cost) best = {next, cost, false};
    });
    nodes_[cell] = best;
  }

  void expand(const Index3& cell) {
    const Index3 parent = nodes_[cell].parent;
    const double cost = nodes_[parent].cost;
    for_each_neighbour(cell, [&](const Index3& next) {
      Node& node = nodes_[next];
      const double through = cost + distance(parent, next);
      if (node.is_closed || through >= node.cost) return;
      node = {parent, through, false};
      open_.push({through + distance(next, goal_), next});
    });
  }

  std::vector<Vec3> trace() {
    std::vector<Vec3> out;
    for (Index3 at = goal_;; at = nodes_[at].parent) {
      out.insert(out.begin(), geometry::center_of(at, field_.resolution_m()));
      if (at == start_) return out;
    }
  }

  const planning::ClearanceField& field_;
  Index3 start_, goal_;
  std::unordered_map<Index3, Node, geometry::Index3Hash> nodes_;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> open_;
};

}  // namespace voxnav::test
