// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "planning/path/bound_search.hpp"

namespace voxnav::planning {

/// Lazy Theta* over runs of cells, from the goal back to the start, led by the costs of a BoundSearch from the start.
/// Each run is passed at one place: its centre, at the height at which a straight line from the turn before to the
/// start would pass, as far as the run reaches. Each run is expanded at most once; one whose line of sight turns out to
/// be blocked returns to the open list with its true cost. Source: Nash, Koenig & Tovey, Lazy Theta*, AAAI 2010.
class AnyAngleSearch {
 public:
  AnyAngleSearch(RunGraph* graph, const BoundSearch* bounds, const geometry::Vec3& start)
      : graph_(*graph), bounds_(*bounds), start_(start) {}

  /// @return the points from the start to the goal, between which the lines of sight are clear; empty if the limits of
  ///         the budget or the runs are exhausted
  std::vector<geometry::Vec3> run(RunGraph::Number start, RunGraph::Number goal, const geometry::Vec3& goal_point,
                                  WorkBudget* budget);
  std::uint64_t expansions() const { return expansions_; }
  std::size_t memory_bytes() const { return places_.capacity() * sizeof(Place) + open_.memory_bytes(); }

 private:
  using Number = RunGraph::Number;
  struct Place {
    geometry::Vec3 position = geometry::Vec3::Zero();
    double cost = std::numeric_limits<double>::infinity();  ///< from the goal
    Number parent = RunGraph::kNone;
    bool is_seen = false;  ///< the line of sight to the parent has been checked
    bool is_closed = false;
  };

  Place& place(Number number) {
    if (number >= places_.size()) places_.resize(graph_.size());
    return places_[number];
  }
  double mean_cost(Number a, Number b) const {
    return (graph_.node(a).run.cost + graph_.node(b).run.cost) / (2.0 * kUnitCost);
  }
  double heuristic(Number number, const geometry::Vec3& position) const;
  void push(Number number);
  bool check_sight(Number number);
  void expand(Number from);
  void relax(Number from, Number to, int low, int high);
  std::optional<double> step_height(Number from, Number to);
  std::optional<double> step_cost(Number from, Number to);
  bool opens_at(int x, int y, double height);
  std::vector<geometry::Vec3> trace();

  RunGraph& graph_;
  const BoundSearch& bounds_;
  geometry::Vec3 start_;
  Number start_run_ = RunGraph::kNone;
  std::vector<Place> places_;
  OpenList<double, RunGraph::Number> open_{1.0 / kSlotsPerEdge};
  std::uint64_t expansions_ = 0;
};

}  // namespace voxnav::planning
