// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planning/path/open_list.hpp"
#include "planning/path/run_graph.hpp"

namespace voxnav::planning {

/// What one planning call may still spend.
struct WorkBudget {
  std::uint64_t expansions_left = 0;
  std::size_t max_bytes = 0;
};

/// A* from the start over runs of cells as if each were one place: moving up and down in a run costs nothing. So no
/// path over the lattice of cells costs less than what this search finds, and a second search knows where to look. With
/// a weight it expands less, and what it finds costs at most that factor more than the bound, since its heuristic is
/// consistent. Source: Likhachev, Gordon & Thrun, ARA*, NIPS 2003, section 2 (no run is expanded twice).
class BoundSearch {
 public:
  enum class End { kGoal, kExhausted, kLimit };

  /// Costs are integers: a step of one voxel edge at unit cost is kStraight * 2 * kUnitCost. 41 / 29 is just below the
  /// square root of two, and kVertical / kStraight below the difference of the roots of three and of two, so that sums
  /// never exceed the cost of a diagonal step in space.
  static constexpr std::uint64_t kStraight = 29;
  static constexpr std::uint64_t kDiagonal = 41;
  static constexpr std::uint64_t kVertical = 9;
  static constexpr std::uint64_t kUnit = kStraight * 2 * kUnitCost;

  BoundSearch(RunGraph* graph, RunGraph::Number goal, double weight = 1.0)
      : graph_(*graph), goal_(goal), goal_node_(graph->node(goal)), weight_(weight) {}

  End run(RunGraph::Number start, WorkBudget* budget);

  /// The cost of the goal as it was found [voxel edges at unit cost], at most the weight times its lower bound.
  /// Precondition: run() reached it.
  double goal_cost() const;
  /// Lower bound of the cost from the start to a run [voxel edges at unit cost], exact for runs that run() expanded.
  /// Precondition: the weight is 1.
  double bound(RunGraph::Number number) const;
  /// The cost from the start to a run as it was found, with any weight, and for a run that was not reached what it
  /// would be at least, so that another search may be led by it [voxel edges at unit cost].
  double leading_cost(RunGraph::Number number) const;
  /// Among the expanded runs, the one nearest to a point.
  RunGraph::Number nearest_to(const geometry::Vec3& point) const;
  std::uint64_t expansions() const { return expansions_; }
  std::size_t memory_bytes() const { return reached_.capacity() * sizeof(Reached) + open_.memory_bytes(); }

 private:
  /// The cost of a run and whether it was expanded, in one word.
  class Reached {
   public:
    std::uint64_t cost() const { return word_ >> 1; }
    bool is_closed() const { return (word_ & 1u) != 0; }
    bool is_reached() const { return word_ != ~std::uint64_t{1}; }
    /// Whether a way at this cost is an improvement, which no expanded run takes.
    bool is_dearer(std::uint64_t cost) const { return cost < (word_ >> 1) && (word_ & 1u) == 0; }
    void set_cost(std::uint64_t cost) { word_ = cost << 1; }
    void close() { word_ |= 1u; }

   private:
    std::uint64_t word_ = ~std::uint64_t{1};
  };

  std::uint64_t heuristic(const RunGraph::Node& node) const;
  Reached& reached(RunGraph::Number number) {
    if (number >= reached_.size()) reached_.resize(graph_.size());
    return reached_[number];
  }
  void expand(RunGraph::Number from, std::uint64_t cost);
  void relax(RunGraph::Number to, std::uint64_t cost);
  void reach(RunGraph::Number to, std::uint64_t cost);

  RunGraph& graph_;
  RunGraph::Number goal_;
  RunGraph::Node goal_node_;
  double weight_;
  std::vector<Reached> reached_;
  OpenList<std::uint64_t, RunGraph::Number> open_{kUnit / kSlotsPerEdge};
  std::uint64_t expansions_ = 0;
  std::uint64_t last_f_ = 0;  ///< no run that was not expanded has a lower sum of cost and heuristic
};

}  // namespace voxnav::planning
