// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::planning {

/// Why a search ended as it did. Only kComplete reaches the goal that was asked for.
enum class PlanStatus {
  kComplete,
  kPartialTimeout,  ///< time ran out; the path leads to the expanded cell nearest to the goal
  kPartialLimit,    ///< expansions or memory ran out; the path leads to the expanded cell nearest to the goal
  kPartialBlocked,  ///< all reachable cells were searched; the path leads to the one nearest to the goal
  kNoPath,          ///< no reachable cell is nearer to the goal than the start
  kStartBlocked,    ///< start occupied, or too near to an obstacle with no way out
  kStartUnknown,
  kGoalBlocked,  ///< goal occupied or too near to an obstacle; the path leads to a free cell near it
  kGoalUnknown,
  kGoalEnclosed,     ///< the goal is free or unknown, but obstacles enclose the space around it
  kGoalBelowGround,  ///< the goal is unknown, and the ground covers it far around
  kOutsideMap,       ///< start or goal outside the view's box; the path, if any, leads towards the goal
  kStartFenced,      ///< the start is outside the safety area or in a no-fly zone; there is no path from it
  kGoalFenced,       ///< the goal is outside the safety area or in a no-fly zone; there is no path to it
  kInvalidInput
};

constexpr auto words_of(PlanStatus) {
  return std::array{"complete",          "partial_timeout", "partial_limit", "partial_blocked", "no_path",
                    "start_blocked",     "start_unknown",   "goal_blocked",  "goal_unknown",    "goal_enclosed",
                    "goal_below_ground", "outside_map",     "start_fenced",  "goal_fenced",     "invalid_input"};
}
/// Explains a status in one sentence for people.
const char* explain(PlanStatus status);

struct PlanResult {
  PlanStatus status = PlanStatus::kInvalidInput;
  std::vector<geometry::Vec3> path;  ///< voxel centres from start to end, neighbours touch unless simplified
  bool is_partial = false;           ///< there is a path, but it does not end at the goal that was asked for
  double cost_m = 0.0;               ///< length of the path weighted by the cost of its cells, before simplifying
  double remaining_m = 0.0;          ///< straight distance from the end of the path to the goal
  std::uint64_t expansions = 0;
  double seconds = 0.0;
  std::uint64_t memory_bytes = 0;  ///< memory that the search held when it ended
};

}  // namespace voxnav::planning
