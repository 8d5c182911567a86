// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "planning/path/bound_search.hpp"

namespace voxnav::planning {

/// Weighted A* over runs of cells, from the goal back to the start, led by the costs that a BoundSearch from the start
/// has found. It passes each run at one height: that at which it came in, or the one nearest to it where the run
/// reaches, so that changes of height cost something, other than in a BoundSearch. Where they cost little it expands
/// hardly more than the runs of its path. How good that is must be judged by a bound. Positions are in voxel edges.
class RunSearch {
 public:
  RunSearch(RunGraph* graph, const BoundSearch* bounds, double weight)
      : graph_(*graph), bounds_(*bounds), weight_(weight) {}

  struct End {
    RunGraph::Number run;
    geometry::Vec3 point;  ///< lies in the run
  };
  /// @return points from the start to the goal, over the centres of columns between them, with turns only; empty if the
  ///         limits of the budget or the runs are exhausted
  std::vector<geometry::Vec3> run(const End& start, const End& goal, WorkBudget* budget);
  std::uint64_t expansions() const { return expansions_; }
  std::size_t memory_bytes() const { return places_.capacity() * sizeof(Place) + open_.memory_bytes(); }

 private:
  using Number = RunGraph::Number;
  struct Place {
    double height = 0.0;
    double cost = std::numeric_limits<double>::infinity();
    Number parent = RunGraph::kNone;
    bool is_closed = false;
  };

  Place& place(Number number) {
    if (number >= places_.size()) places_.resize(graph_.size());
    return places_[number];
  }
  void expand(Number from);
  void relax(Number from, Number to, double height, double length);
  bool opens_at(int x, int y, double height);
  geometry::Vec3 position(Number number);
  std::vector<geometry::Vec3> trace(const End& start, const End& goal);

  RunGraph& graph_;
  const BoundSearch& bounds_;
  double weight_;
  double start_height_ = 0.0;
  std::vector<Place> places_;
  OpenList<double, RunGraph::Number> open_{1.0 / kSlotsPerEdge};
  std::uint64_t expansions_ = 0;
};

}  // namespace voxnav::planning
