// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/planning_manager.hpp"

namespace voxnav::pipeline {

std::vector<std::string> PlanningManagerConfig::problems() const {
  std::vector<std::string> out;
  if (min_corridor_radius_m > corridor_radius_m) {
    out.emplace_back("min_corridor_radius_m must not be above corridor_radius_m");
  }
  if (replan_deviation_m > brake_deviation_m) {
    out.emplace_back("replan_deviation_m must not be above brake_deviation_m");
  }
  return out;
}

}  // namespace voxnav::pipeline
