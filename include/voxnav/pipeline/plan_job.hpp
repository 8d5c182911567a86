// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/pipeline/planning_manager_config.hpp"
#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/flight_time.hpp"

namespace voxnav::pipeline {

/// A search and what may be flown of its path.
struct PlanOutcome {
  planning::PlanResult plan;
  std::vector<geometry::Vec3> waypoints_O;  ///< from the start to a stop in known free space; empty when there is none
  bool is_to_goal = false;  ///< the last waypoint is the goal, or so near to a blocked one that it counts as reached
  double corridor_radius_m = 0.0;  ///< known free around the waypoints
  double left_m = 0.0;             ///< way from the last waypoint to the goal, as planned
  std::string problem;             ///< why there are no waypoints, for a person
};

/// What is to be planned.
struct PlanTask {
  geometry::Vec3 start_O;
  geometry::Vec3 goal_O;
  planning::DynamicsLimits limits;           ///< must be valid
  const planning::StopFlag* stop = nullptr;  ///< ends the search; null: the planner's own timeout does
};

/// Searches a way, then cuts it: to known free space with room to stop, and to the longest flight time.
/// Takes as long as the search; safe to run in any thread.
PlanOutcome run_plan_job(const planning::AStarPlanner& planner, const PlanningManagerConfig& config,
                         const planning::OccupancyView& view, const PlanTask& task);

}  // namespace voxnav::pipeline
