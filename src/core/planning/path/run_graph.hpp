// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <limits>
#include <unordered_map>

#include "planning/path/run_costs.hpp"

namespace voxnav::planning {

/// The runs of cells that searches touch, in towers of 16 x 16 columns that are made when first asked for. Positions
/// are in voxel edges here: voxel i covers [i, i + 1).
class RunGraph {
 public:
  using Number = std::uint32_t;
  static constexpr Number kNone = std::numeric_limits<Number>::max();

  struct Node {
    std::int32_t x;
    std::int32_t y;
    CellRun run;
  };
  /// Numbers of the runs of a column: first <= n < end.
  struct Column {
    Number first = 0;
    Number end = 0;
    bool is_empty() const { return first == end; }
  };
  struct Step {
    int dx;
    int dy;
  };
  static constexpr std::array<Step, 8> kSteps = {
      {{1, 0}, {-1, 0}, {0, 1}, {0, -1}, {1, 1}, {1, -1}, {-1, 1}, {-1, -1}}};

  /// @param max_bytes  memory of all towers; columns beyond it are empty, and has_refused() tells
  RunGraph(const RunCosts* costs, std::size_t max_bytes) : costs_(*costs), max_bytes_(max_bytes) {}

  /// Makes the column's tower if need be.
  Column column(int x, int y) {
    const Tower* found = tower(x >> geometry::kBlockShift, y >> geometry::kBlockShift);
    if (found == nullptr) return {};
    const int at = column_at(x & (geometry::kBlockSide - 1), y & (geometry::kBlockSide - 1));
    return {found->first[at], found->first[at + 1]};
  }
  /// The run that holds a voxel, kNone if it may not be entered.
  Number find(const geometry::Index3& voxel) {
    const Column there = column(voxel.x, voxel.y);
    for (Number n = there.first; n < there.end; ++n) {
      if (nodes_[n].run.low <= voxel.z && voxel.z <= nodes_[n].run.high) return n;
    }
    return kNone;
  }
  const Node& node(Number number) const { return nodes_[number]; }
  std::size_t size() const { return nodes_.size(); }
  bool has_refused() const { return has_refused_; }
  std::size_t memory_bytes() const;
  const RunCosts& costs() const { return costs_; }

  /// The columns at all steps from a run; no other call is needed to make them. Most lie in the tower of the run.
  std::array<Column, 8> columns_beside(const Node& node) {
    constexpr int kLast = geometry::kBlockSide - 1;
    const int x = node.x & kLast, y = node.y & kLast;
    std::array<Column, 8> out;
    if (x > 0 && x < kLast && y > 0 && y < kLast) {
      const Number* first = &tower(node.x >> geometry::kBlockShift, node.y >> geometry::kBlockShift)->first[0];
      for (int i = 0; i < 8; ++i) {
        const int at = column_at(x + kSteps[i].dx, y + kSteps[i].dy);
        out[i] = {first[at], first[at + 1]};
      }
    } else {
      for (int i = 0; i < 8; ++i) out[i] = column(node.x + kSteps[i].dx, node.y + kSteps[i].dy);
    }
    return out;
  }
  /// Whether a column has a run that shares heights with a range.
  bool opens_within(const Column& column, int low, int high) const {
    for (Number n = column.first; n < column.end; ++n) {
      if (nodes_[n].run.low <= high && nodes_[n].run.high >= low) return true;
    }
    return false;
  }
  /// Calls fn(number, step, lowest and highest common z) for the runs beside a run that share heights with it, where
  /// all columns that a diagonal step touches may be entered. Searches that call it see each run as one place.
  /// @param is_wanted  function of a number that returns false for runs to be passed over
  template <class Wanted, class Fn>
  void for_each_beside(Number from, Wanted is_wanted, Fn fn);

 private:
  struct Tower {
    std::array<Number, kColumns + 1> first;
  };

  /// A tower that was asked for not long ago. Searches go to and fro between a few that lie side by side.
  struct Recent {
    geometry::Index3 place{std::numeric_limits<std::int32_t>::min(), 0, 0};
    const Tower* tower = nullptr;
  };
  static constexpr std::size_t kRecentSide = 4;

  const Tower* tower(int x, int y) {
    const std::size_t column = static_cast<std::size_t>(x) % kRecentSide,
                      row = static_cast<std::size_t>(y) % kRecentSide;
    Recent& recent = recent_[column + kRecentSide * row];
    if (recent.place.x != x || recent.place.y != y) recent = {{x, y, 0}, find_tower(x, y)};
    return recent.tower;
  }
  /// Null outside the bounds, and beyond the allowed memory.
  const Tower* find_tower(int x, int y);
  const Tower* make_tower(int x, int y);
  const RunCosts& costs_;
  std::size_t max_bytes_;
  bool has_refused_ = false;
  std::vector<Node> nodes_;
  std::vector<std::unique_ptr<Tower>> towers_;
  std::unordered_map<geometry::Index3, const Tower*, geometry::Index3Hash> by_place_;
  std::vector<TowerBlock> blocks_;
  std::array<Recent, kRecentSide * kRecentSide> recent_;
};

template <class Wanted, class Fn>
void RunGraph::for_each_beside(Number from, Wanted is_wanted, Fn fn) {
  const Node here = nodes_[from];
  const std::array<Column, 8> beside = columns_beside(here);
  for (int i = 0; i < 8; ++i) {
    const Step step = kSteps[i];
    // Most diagonal steps are out of the question already because a column beside them is closed.
    if (i >= 4 && (beside[step.dx > 0 ? 0 : 1].is_empty() || beside[step.dy > 0 ? 2 : 3].is_empty())) continue;
    for (Number n = beside[i].first; n < beside[i].end; ++n) {
      const int low = std::max(here.run.low, nodes_[n].run.low), high = std::min(here.run.high, nodes_[n].run.high);
      if (low > high || !is_wanted(n)) continue;
      if (i >= 4 && !(opens_within(beside[step.dx > 0 ? 0 : 1], low, high) &&
                      opens_within(beside[step.dy > 0 ? 2 : 3], low, high))) {
        continue;
      }
      fn(n, step, low, high);
    }
  }
}

}  // namespace voxnav::planning
