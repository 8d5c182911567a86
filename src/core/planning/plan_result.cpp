// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/plan_result.hpp"

namespace voxnav::planning {

const char* explain(PlanStatus status) {
  switch (status) {
    case PlanStatus::kComplete:
      return "path reaches the goal";
    case PlanStatus::kPartialTimeout:
      return "search ran out of time";
    case PlanStatus::kPartialLimit:
      return "search reached its limit of cells or memory";
    case PlanStatus::kPartialBlocked:
      return "no way through to the goal";
    case PlanStatus::kNoPath:
      return "nothing nearer to the goal can be reached";
    case PlanStatus::kStartBlocked:
      return "start is inside or too near to an obstacle, a fence or a limit of height";
    case PlanStatus::kStartUnknown:
      return "start is in unknown space";
    case PlanStatus::kGoalBlocked:
      return "goal is inside or too near to an obstacle, a fence or a limit of height";
    case PlanStatus::kGoalUnknown:
      return "goal is in unknown space";
    case PlanStatus::kGoalEnclosed:
      return "goal is enclosed by obstacles";
    case PlanStatus::kGoalBelowGround:
      return "goal is below the ground";
    case PlanStatus::kOutsideMap:
      return "start or goal is outside the map";
    case PlanStatus::kStartFenced:
      return "start is outside the safety area or in a no-fly zone";
    case PlanStatus::kGoalFenced:
      return "goal is outside the safety area or in a no-fly zone";
    case PlanStatus::kInvalidInput:
      return "start or goal is not a finite position";
  }
  return "";
}

}  // namespace voxnav::planning
