// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "planning/path/run_graph.hpp"

namespace voxnav::planning {

/// Where a path can begin and end. Positions are in voxel edges.
struct PathEnds {
  /// kComplete, or why the point that was asked for cannot be reached. Without a start or goal run there is no path.
  PlanStatus status = PlanStatus::kComplete;
  std::vector<geometry::Index3> way_out;  ///< cells from the start to the first one that a path may enter
  geometry::Index3 goal_cell{0, 0, 0};
  RunGraph::Number start_run = RunGraph::kNone;
  RunGraph::Number goal_run = RunGraph::kNone;
  bool is_substitute = false;  ///< the goal cell is one near the goal that can be reached

  bool has_path() const { return start_run != RunGraph::kNone && goal_run != RunGraph::kNone; }
};

/// Finds the ends of a path: a start that may not be entered is left, and a goal that cannot be reached is replaced by
/// the nearest cell that can. Whether there is a way is known from the labels of the field, before any search.
PathEnds find_ends(RunGraph* graph, const PathPlannerConfig& config, const geometry::Vec3& start,
                   const geometry::Vec3& goal);

}  // namespace voxnav::planning
