// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/clearance_field.hpp"

namespace voxnav::planning {

/// Costs and limits of a path. The limits bound the work, never the time, so that a loaded machine finds the same path.
struct PathPlannerConfig {
  int max_expansions = 1000000;
  double max_memory_mib = 256.0;
  double clearance_distance_m = 0.0;
  double clearance_weight = 2.0;
  UnknownPolicy unknown_policy = UnknownPolicy::kForbid;
  double unknown_cost = 2.0;
  double optimistic_range_m = 8.0;
  double known_distance_m = 0.0;
  double near_unknown_weight = 10.0;
  double suboptimality_bound = 1.05;
  bool quick = false;
  double goal_search_radius_m = 4.0;
  double escape_distance_m = 3.0;
  int max_shortening_checks = 4000;

  template <class V>
  static void fields(V&& v) {
    v("max_expansions", &PathPlannerConfig::max_expansions, base::in(1, 50000000), "",
      "runs of cells expanded at most");
    v("max_memory_mib", &PathPlannerConfig::max_memory_mib, base::in(4.0, 8192.0), "MiB", "memory of one search");
    v("clearance_distance_m", &PathPlannerConfig::clearance_distance_m, base::in(0.0, 20.0), "m",
      "cells nearer to occupied voxels than this cost more; no effect unless above the field's safety distance");
    v("clearance_weight", &PathPlannerConfig::clearance_weight, base::in(0.0, 100.0), "",
      "extra cost per metre at the safety distance, falls to zero at clearance_distance_m");
    v("unknown_policy", &PathPlannerConfig::unknown_policy, base::one_of<UnknownPolicy>(), "",
      "unknown cells: never; at unknown_cost; at unknown_cost beyond optimistic_range_m of the start only");
    v("unknown_cost", &PathPlannerConfig::unknown_cost, base::in(1.0, 100.0), "", "cost per metre in unknown cells");
    v("optimistic_range_m", &PathPlannerConfig::optimistic_range_m, base::in(0.0, 1000.0), "m",
      "range around the start in which the policy optimistic_far forbids unknown cells");
    v("known_distance_m", &PathPlannerConfig::known_distance_m, base::in(0.0, 10.0), "m",
      "within optimistic_range_m of the start, cells nearer than this to unknown ones cost more; 0 = no effect");
    v("near_unknown_weight", &PathPlannerConfig::near_unknown_weight, base::in(0.0, 100.0), "",
      "extra cost per metre of cells nearer to unknown ones than known_distance_m");
    v("suboptimality_bound", &PathPlannerConfig::suboptimality_bound, base::in(1.0, 5.0), "",
      "the path costs at most this factor more than the cheapest one over the lattice of cells, unless a limit ends "
      "the "
      "search");
    v("quick", &PathPlannerConfig::quick, base::any(), "",
      "take the first path that keeps suboptimality_bound, which is found several times faster, instead of searching "
      "on "
      "in all directions for a shorter one");
    v("goal_search_radius_m", &PathPlannerConfig::goal_search_radius_m, base::in(0.0, 20.0), "m",
      "a goal that cannot be entered is replaced by the nearest cell within this radius that can be reached; the "
      "radius "
      "grows where the goal is unknown or outside the map");
    v("escape_distance_m", &PathPlannerConfig::escape_distance_m, base::in(0.0, 20.0), "m",
      "a start too near to an obstacle may be left over this distance at most, never through occupied cells");
    v("max_shortening_checks", &PathPlannerConfig::max_shortening_checks, base::in(0, 1000000), "",
      "segments whose clearance is checked at most while the path is made shorter");
  }
};

/// A path of straight segments in any direction.
struct AnyAnglePlan : PlanResult {
  double length_m = 0.0;
  /// No path over the lattice of cells costs less than this, so cost_m / lower_bound_m bounds how much too dear the
  /// path is. Infinite where there is no way.
  double lower_bound_m = 0.0;
};

/// Finds short paths on a clearance field in four steps:
/// 1. A* over the runs of cells that lie on top of each other at equal cost, which stand for all their cells, so that
///    open space costs no more than its ground plan. Its cost is a lower bound.
/// 2. Lazy Theta* back from the goal over the same runs, led by the costs of step 1, with lines of sight in space.
/// 3. Shortening in continuous space. Each segment keeps the safety distance exactly to the boxes of occupied voxels.
/// 4. If the path costs more than suboptimality_bound times the lower bound: weighted A* over single cells, led by the
///    costs of step 1, whose path keeps that bound and is shortened as well. The cheaper path is taken.
/// With `quick`, step 1 is weighted by suboptimality_bound first, and its own path is shortened; only if that misses
/// the bound, the four steps follow. Each run is expanded at most once in each of the two searches. Deterministic; all
/// limits are numbers of operations. A planner may be used from several threads. Source: Nash, Koenig & Tovey, Lazy
/// Theta*, AAAI 2010; Reijgwart et al., RSS 2025 (arXiv 2602.21174): cells of many sizes, here of many heights.
/// docs/maths/planning.md has the formulas.
class PathPlanner {
 public:
  /// @throws base::ConfigError
  explicit PathPlanner(const PathPlannerConfig& config);

  /// Searches a path between two points of the field's frame [m].
  /// @return kInvalidInput if a point is not finite; `cost_m` is that of the path as it is returned
  /// @throws std::invalid_argument if the field keeps distances up to less than clearance_distance_m or
  /// known_distance_m
  AnyAnglePlan plan(const ClearanceField& field, const geometry::Vec3& start, const geometry::Vec3& goal) const;

  const PathPlannerConfig& config() const { return config_; }

 private:
  PathPlannerConfig config_;
};

}  // namespace voxnav::planning
