// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/planning/a_star_config.hpp"
#include "voxnav/planning/occupancy_view.hpp"
#include "voxnav/planning/plan_result.hpp"
#include "voxnav/planning/stop_flag.hpp"

namespace voxnav::planning {

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
  /// @param stop   flag that ends the search once it is raised and replaces timeout_s; with null the search ends after
  ///               timeout_s of wall time
  /// @note O(n log n) in expanded cells; growing obstacles costs O(radius) for each touched cell
  PlanResult plan(const OccupancyView& view, const geometry::Vec3& start, const geometry::Vec3& goal,
                  const StopFlag* stop = nullptr) const;

  const AStarConfig& config() const { return config_; }

 private:
  AStarConfig config_;
};

}  // namespace voxnav::planning
