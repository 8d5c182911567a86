// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/planning/a_star_config.hpp"

namespace voxnav::pipeline {

/// The search as the planning manager uses it: fields of AStarConfig, defaults for flight into unknown space. Far
/// unknown space may be planned through, because only the known free part of a plan is ever flown.
struct FlightSearchConfig : planning::AStarConfig {
  FlightSearchConfig() {
    // What 0.6 s are enough for on a small computer: the work bounds a search, not the load of the machine.
    max_expansions = 300000;
    timeout_s = 0.6;
    clearance_distance_m = 2.0;
    unknown_policy = planning::UnknownPolicy::kOptimisticFar;
    // More would make the search flood all known space before it enters unknown space.
    unknown_cost = 1.1;
    optimistic_range_m = 4.0;
    // Corridor radius and deviation of the trajectory: a plan that lacks this much is not flown.
    known_distance_m = 0.9;
    heuristic_weight = 1.2;
    simplify = true;
  }
};

}  // namespace voxnav::pipeline
