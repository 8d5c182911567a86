// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/planning/trajectory.hpp"

namespace voxnav::pipeline {

/// What the planning manager wants done. Each is answered by the *_done call of the same name, from any time on.
enum class ActionKind {
  kPlan,      ///< run_plan_job from `start_O` to `goal_O`
  kGenerate,  ///< ask the generator for a trajectory through `waypoints_O`
  kPublish,   ///< hand `trajectory` to the tracker, to be flown at once
  kHover      ///< stop now
};

struct Action {
  ActionKind kind = ActionKind::kHover;
  std::uint64_t job = 0;  ///< to be given back with the answer
  std::string reason;
  geometry::Vec3 start_O = geometry::Vec3::Zero();
  geometry::Vec3 goal_O = geometry::Vec3::Zero();
  /// When the vehicle will be at the start [s]; nothing when it rests there.
  std::optional<double> start_stamp_s;
  std::vector<geometry::Vec3> waypoints_O;
  std::optional<double> heading_rad;  ///< at the last waypoint, if it is the goal and the goal has one; frame O
  planning::Trajectory trajectory;
};
using Actions = std::vector<Action>;

enum class PlannerState { kIdle = 0, kPlanning = 1, kMoving = 2 };

/// For people and for the status message.
struct PlanningStatus {
  PlannerState state = PlannerState::kIdle;
  std::string reason = "no goal";
  std::optional<geometry::Vec3> goal_W;
  bool is_goal_reached = false;  ///< the last goal
  std::string plan_status;       ///< of the last search
  std::uint64_t expansions = 0;
  double plan_s = 0.0;
  std::uint32_t num_plans = 0;
  std::uint32_t num_trajectories = 0;
  std::uint32_t num_shortened = 0;
  std::uint32_t num_hovers = 0;
};

}  // namespace voxnav::pipeline
