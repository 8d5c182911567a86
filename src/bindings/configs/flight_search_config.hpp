// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/planning/a_star.hpp"

namespace voxnav::bindings {

/// The parameters of the search in the planning manager: the fields of AStarConfig with defaults for flight into
/// unknown space. Plans may lead through far unknown space, because only the known free part of a plan is ever flown.
struct FlightSearchConfig : planning::AStarConfig {
  FlightSearchConfig() {
    // As many expansions as a small computer makes in 0.6 s. A bound on work does not depend on the load of the
    // machine.
    max_expansions = 300000;
    timeout_s = 0.6;
    clearance_distance_m = 2.0;
    unknown_policy = planning::UnknownPolicy::kOptimisticFar;
    // With a higher cost the search would flood all known space before it enters unknown space.
    unknown_cost = 1.1;
    optimistic_range_m = 4.0;
    // Corridor radius plus deviation of the trajectory: a plan with less known space around it is not flown.
    known_distance_m = 0.9;
    heuristic_weight = 1.2;
    simplify = true;
  }
};

}  // namespace voxnav::bindings
