// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/planning/a_star_config.hpp"
#include "voxnav/planning/occupancy_view.hpp"
#include "voxnav/planning/plan_result.hpp"
#include "voxnav/planning/stop_flag.hpp"

namespace voxnav::planning {

/// Bounded A* on the voxels of a view: 26 neighbours, no corner cutting, octile distance as heuristic, ties to the
/// larger cost so far, lazy duplicates in the open list. Each cell is expanded at most once; the path is the cheapest
/// with heuristic_weight 1, else at most that factor dearer. Every search ends within the limits of its
/// configuration and says why; a partial path leads to the expanded cell nearest to the goal.
/// Deterministic unless time runs out. A planner may be used from several threads.
/// Source: Hart, Nilsson & Raphael 1968 (A*); Harabor & Grastien 2011, section 2 (octile metric, corner rule);
/// Likhachev, Gordon & Thrun 2003, section 2 (the bound holds although closed cells are not opened again).
class AStarPlanner {
 public:
  /// @throws base::ConfigError
  explicit AStarPlanner(const AStarConfig& config);

  /// @param view must not change during the call
  /// @param start, goal in the view's frame [m]; not finite gives kInvalidInput
  /// @param stop ends the search once it is raised, in the place of timeout_s; null: timeout_s of wall time does
  /// @note O(n log n) in expanded cells; growing obstacles costs O(radius) per touched cell
  PlanResult plan(const OccupancyView& view, const geometry::Vec3& start, const geometry::Vec3& goal,
                  const StopFlag* stop = nullptr) const;

  const AStarConfig& config() const { return config_; }

 private:
  AStarConfig config_;
};

}  // namespace voxnav::planning
