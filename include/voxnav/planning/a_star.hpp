// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "voxnav/base/config.hpp"
#include "voxnav/planning/occupancy_view.hpp"
#include "voxnav/planning/plan_result.hpp"

namespace voxnav::planning {

/// How a search treats unknown cells.
enum class UnknownPolicy {
  kForbid,        ///< the path never enters unknown cells
  kPenalise,      ///< the path may enter unknown cells at unknown_cost per metre
  kOptimisticFar  ///< as kPenalise beyond optimistic_range_m of the start, as kForbid nearer to it
};
constexpr auto words_of(UnknownPolicy) { return std::array{"forbid", "penalise", "optimistic_far"}; }

/// Costs and limits of a search. The limits bound time and memory whatever the map and the goal are.
struct AStarConfig {
  int max_expansions = 1000000;
  double timeout_s = 0.8;
  double max_memory_mib = 256.0;
  double safety_distance_m = 1.0;
  double clearance_distance_m = 0.0;
  double clearance_weight = 2.0;
  UnknownPolicy unknown_policy = UnknownPolicy::kForbid;
  double unknown_cost = 2.0;
  double optimistic_range_m = 8.0;
  double known_distance_m = 0.0;
  double near_unknown_weight = 10.0;
  double heuristic_weight = 1.0;
  double goal_search_radius_m = 4.0;
  double escape_distance_m = 3.0;
  bool simplify = false;

  template <class V>
  static void fields(V&& v) {
    v("max_expansions", &AStarConfig::max_expansions, base::in(1, 50000000), "", "cells expanded at most");
    v("timeout_s", &AStarConfig::timeout_s, base::in(0.001, 60.0), "s", "time for one search");
    v("max_memory_mib", &AStarConfig::max_memory_mib, base::in(4.0, 8192.0), "MiB",
      "memory for nodes and open list, half each");
    v("safety_distance_m", &AStarConfig::safety_distance_m, base::in(0.0, 10.0), "m",
      "every point of the path stays this far from occupied voxels");
    v("clearance_distance_m", &AStarConfig::clearance_distance_m, base::in(0.0, 20.0), "m",
      "cells nearer to occupied voxels than this cost more; no effect unless above safety_distance_m");
    v("clearance_weight", &AStarConfig::clearance_weight, base::in(0.0, 100.0), "",
      "extra cost per metre at the safety distance, falls to zero at clearance_distance_m");
    v("unknown_policy", &AStarConfig::unknown_policy, base::one_of<UnknownPolicy>(), "",
      "unknown cells: never; at unknown_cost; at unknown_cost beyond optimistic_range_m of the start only");
    v("unknown_cost", &AStarConfig::unknown_cost, base::in(1.0, 100.0), "", "cost per metre in unknown cells");
    v("optimistic_range_m", &AStarConfig::optimistic_range_m, base::in(0.0, 1000.0), "m",
      "range around the start in which the policy optimistic_far forbids unknown cells");
    v("known_distance_m", &AStarConfig::known_distance_m, base::in(0.0, 10.0), "m",
      "within optimistic_range_m of the start, cells nearer than this to unknown ones cost more: what is to be flown "
      "next needs known space around it; 0 = no effect");
    v("near_unknown_weight", &AStarConfig::near_unknown_weight, base::in(0.0, 100.0), "",
      "extra cost per metre of cells nearer to unknown ones than known_distance_m");
    v("heuristic_weight", &AStarConfig::heuristic_weight, base::in(1.0, 5.0), "",
      "1 gives the cheapest path; with a higher weight the search is faster, and the path costs at most this factor "
      "more");
    v("goal_search_radius_m", &AStarConfig::goal_search_radius_m, base::in(0.0, 20.0), "m",
      "a goal that cannot be entered is replaced by the nearest enterable cell within this radius");
    v("escape_distance_m", &AStarConfig::escape_distance_m, base::in(0.0, 20.0), "m",
      "a start too near to an obstacle may be left over this distance at most, never through occupied cells");
    v("simplify", &AStarConfig::simplify, base::any(), "", "shorten the path along clear lines of sight");
  }
};

/// Bounded weighted A* on the voxels of a view, with 26 neighbours and without corner cutting. The heuristic is the
/// octile distance; ties go to the larger cost so far; the open list deletes duplicates lazily. Each cell is expanded
/// at most once: the path is the cheapest one with heuristic_weight 1, else its cost is at most that factor higher.
/// Every search ends within the limits of its configuration and reports why it ended; a partial path leads to the
/// expanded cell nearest to the goal. Deterministic unless time runs out. A planner may be used from several threads.
/// Source: Hart, Nilsson & Raphael, IEEE Transactions on Systems Science and Cybernetics 1968 (A*); Harabor & Grastien,
/// AAAI 2011, section 2 (octile metric, corner rule); Likhachev, Gordon & Thrun, ARA*, NIPS 2003, section 2 (the bound
/// holds although closed cells are not opened again). docs/maths/planning.md has the formulas.
class AStarPlanner {
 public:
  /// @throws base::ConfigError
  explicit AStarPlanner(const AStarConfig& config);

  /// Searches a path from start to goal.
  /// @param view   map, which must not change during the call
  /// @param start  start and goal in the view's frame [m]; the result is kInvalidInput if one is not finite
  /// @param goal   see start
  /// @note O(n log n) in expanded cells; growing obstacles costs O(radius) for each touched cell
  PlanResult plan(const OccupancyView& view, const geometry::Vec3& start, const geometry::Vec3& goal) const;

  const AStarConfig& config() const { return config_; }

 private:
  AStarConfig config_;
};

}  // namespace voxnav::planning
