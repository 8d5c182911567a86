// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/sight.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {
namespace {

using geometry::Vec3;

constexpr double kTolerance = 1e-9;

/// Without the call of a library that std::floor is on older processors.
int floor_of(double value) {
  const int truncated = static_cast<int>(value);
  return truncated - (value < truncated ? 1 : 0);
}

/// Walks over the columns under a line.
/// Source: Amanatides & Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987, section 2.
class ColumnWalk {
 public:
  ColumnWalk(const Vec3& from, const Vec3& to) : x(floor_of(from.x())), y(floor_of(from.y())), from_(from) {
    direction_ = to - from;
    for (int k = 0; k < 2; ++k) {
      const double d = direction_[k];
      step_[k] = (d > 0.0) - (d < 0.0);
      const double boundary = std::floor(from[k]) + (d > 0.0 ? 1.0 : 0.0);
      delta_[k] = d != 0.0 ? 1.0 / std::abs(d) : 2.0;
      next_[k] = d != 0.0 ? (boundary - from[k]) / d : 2.0;
    }
    leave = std::min({next_[0], next_[1], 1.0});
  }

  double height_at(double t) const { return from_.z() + t * direction_.z(); }
  bool is_last() const { return leave >= 1.0 - kTolerance; }
  bool crosses(int axis) const { return next_[axis] < leave + kTolerance; }
  int step(int axis) const { return step_[axis]; }
  void advance() {
    enter = leave;
    const bool crosses_x = crosses(0), crosses_y = crosses(1);
    if (crosses_x) {
      x += step_[0];
      next_[0] += delta_[0];
    }
    if (crosses_y) {
      y += step_[1];
      next_[1] += delta_[1];
    }
    leave = std::min({next_[0], next_[1], 1.0});
  }

  int x;
  int y;
  double enter = 0.0;  ///< parameters of the line at which it enters and leaves the column
  double leave;

 private:
  Vec3 from_;
  Vec3 direction_;
  std::array<int, 2> step_;
  std::array<double, 2> next_;
  std::array<double, 2> delta_;
};

/// The cells of a column that a line touches between two heights; those that it touches at an edge count as well, so
/// that it cuts no corner.
struct Heights {
  double low;
  double high;
  int first() const { return floor_of(low - kTolerance); }
  int last() const { return floor_of(high + kTolerance); }
  /// Share of the heights that lie in the cells from `a` to `b`.
  double share(int a, int b) const {
    if (high - low < kTolerance) return a <= low && low < b + 1.0 ? 1.0 : 0.0;
    return std::max(0.0, std::min(high, b + 1.0) - std::max(low, static_cast<double>(a))) / (high - low);
  }
};

class SightLine {
 public:
  SightLine(RunGraph* graph, SightRule rule) : graph_(*graph), rule_(rule) {}

  /// Mean cost of the heights of a column, 0 if one of its cells may not be touched.
  double mean_cost(int x, int y, const Heights& heights) {
    const RunGraph::Column column = graph_.column(x, y);
    if (column.end - column.first == 1) {
      const CellRun& run = graph_.node(column.first).run;
      if (run.low <= heights.low - kTolerance && heights.high + kTolerance < run.high + 1) {
        return static_cast<double>(run.cost) / kUnitCost;
      }
    }
    int at = heights.first();
    const int last = heights.last();
    double cost = 0.0;
    for (RunGraph::Number n = column.first; n < column.end && at <= last; ++n) {
      const CellRun& run = graph_.node(n).run;
      if (run.high < at) continue;
      const double gap = cross_gap(x, y, {at, std::min(last, run.low - 1)}, heights);
      if (gap < 0.0) return 0.0;
      cost += gap;
      at = std::max(at, run.low);
      if (at > last) break;
      cost += heights.share(at, std::min(last, run.high)) * run.cost;
      at = run.high + 1;
    }
    const double gap = cross_gap(x, y, {at, last}, heights);
    return gap < 0.0 ? 0.0 : (cost + gap) / kUnitCost;
  }

 private:
  struct Range {
    int low;
    int high;
  };
  /// Cost of cells that are in no run; negative if they may not be touched.
  double cross_gap(int x, int y, const Range& range, const Heights& heights) const {
    double cost = 0.0;
    for (int z = range.low; z <= range.high; ++z) {
      const CellCost here = rule_ == SightRule::kExactlyClear ? graph_.costs().gap_cost({x, y, z}) : CellCost{0};
      if (here == 0) return -1.0;
      cost += heights.share(z, z) * here;
    }
    return cost;
  }

  RunGraph& graph_;
  SightRule rule_;
};

}  // namespace

std::optional<double> sight_cost(RunGraph* graph, const Vec3& from, const Vec3& to, SightRule rule) {
  SightLine line(graph, rule);
  const double length = (to - from).norm();
  double cost = 0.0;
  for (ColumnWalk walk(from, to);; walk.advance()) {
    const double a = walk.height_at(walk.enter), b = walk.height_at(walk.leave);
    const double mean = line.mean_cost(walk.x, walk.y, {std::min(a, b), std::max(a, b)});
    if (mean == 0.0) return std::nullopt;
    cost += (walk.leave - walk.enter) * length * mean;
    if (walk.is_last()) return cost;
    if (!walk.crosses(0) || !walk.crosses(1)) continue;
    // Through the common edge of four columns: the other two are touched as well.
    if (line.mean_cost(walk.x + walk.step(0), walk.y, {b, b}) == 0.0) return std::nullopt;
    if (line.mean_cost(walk.x, walk.y + walk.step(1), {b, b}) == 0.0) return std::nullopt;
  }
}

std::vector<Vec3> cells_along(const Vec3& from, const Vec3& to) {
  std::vector<Vec3> out = {from};
  for (ColumnWalk walk(from, to);; walk.advance()) {
    for (const double t : {walk.enter, walk.leave}) {
      const double height =
          walk.height_at(t) + (t == walk.enter ? 1.0 : -1.0) * kTolerance * (to.z() > from.z() ? 1 : -1);
      const Vec3 center(walk.x + 0.5, walk.y + 0.5, floor_of(height) + 0.5);
      if ((center - out.back()).squaredNorm() > kTolerance) out.push_back(center);
    }
    if (walk.is_last()) break;
  }
  if ((to - out.back()).squaredNorm() > kTolerance) out.push_back(to);
  return out;
}

}  // namespace voxnav::planning
