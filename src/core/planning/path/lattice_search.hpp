// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "planning/path/bound_search.hpp"

namespace voxnav::planning {

/// Weighted A* over single cells with 26 neighbours and without corner cutting, from the goal back to the start, led by
/// the costs of a BoundSearch from the start. Those are consistent, so that no cell is expanded twice and the path
/// costs at most `weight` times as much as the cheapest one over the lattice. It is the second opinion where
/// AnyAngleSearch, which gives no such promise, comes out too dear.
/// Source: Likhachev, Gordon & Thrun, ARA*, NIPS 2003, section 2 (the bound without opening closed cells again).
class LatticeSearch {
 public:
  LatticeSearch(RunGraph* graph, const BoundSearch* bounds, double weight)
      : graph_(*graph), bounds_(*bounds), weight_(weight) {}

  /// @return centres of the cells from the start to the goal; empty if the limits of the budget or the cells are
  ///         exhausted
  std::vector<geometry::Vec3> run(const geometry::Index3& start, const geometry::Index3& goal, WorkBudget* budget);
  std::uint64_t expansions() const { return expansions_; }
  std::size_t memory_bytes() const {
    return cells_.capacity() * sizeof(Cell) + first_cell_.capacity() * sizeof(std::uint32_t) + open_.memory_bytes();
  }

 private:
  using Number = RunGraph::Number;
  struct Cell {
    double cost = std::numeric_limits<double>::infinity();  ///< from the goal
    std::uint8_t move = 0;                                  ///< that leads on towards the goal
    bool is_closed = false;
  };
  /// A cell by the number of its run and its height.
  struct Place {
    Number number;
    std::int32_t z;
    friend bool operator<(const Place& a, const Place& b) {
      return a.number != b.number ? a.number < b.number : a.z < b.z;
    }
  };

  Cell& cell(const Place& place);
  double heuristic(const Place& place) const;
  void push(const Place& place);
  void expand(const Place& from);
  std::vector<geometry::Vec3> trace(geometry::Index3 at, const geometry::Index3& goal);

  RunGraph& graph_;
  const BoundSearch& bounds_;
  double weight_;
  geometry::Index3 start_;
  std::vector<std::uint32_t> first_cell_;  ///< place of a run's lowest cell in cells_, kNone before it is touched
  std::vector<Cell> cells_;
  OpenList<double, Place> open_{1.0 / kSlotsPerEdge};
  std::uint64_t expansions_ = 0;
};

}  // namespace voxnav::planning
