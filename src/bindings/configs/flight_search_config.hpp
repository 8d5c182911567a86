// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "voxnav/planning/path_planner.hpp"

namespace voxnav::bindings {

/// The parameters of the search in the planning manager: those of the path planner, with defaults for flight into
/// unknown space, and of the clearance field on which it searches. Plans may lead through far unknown space, because
/// only the known free part of a plan is ever flown.
struct FlightSearchConfig : planning::PathPlannerConfig {
  double safety_distance_m = 1.0;
  double max_field_memory_mib = 1024.0;

  FlightSearchConfig() {
    // As many expansions as a small computer makes in 0.6 s. A bound on work does not depend on the load of the
    // machine.
    max_expansions = 300000;
    clearance_distance_m = 2.0;
    unknown_policy = planning::UnknownPolicy::kOptimisticFar;
    // With a higher cost the search would flood all known space before it enters unknown space.
    unknown_cost = 1.1;
    optimistic_range_m = 4.0;
    // Corridor radius plus deviation of the trajectory: a plan with less known space around it is not flown.
    known_distance_m = 0.9;
    // In flight a way that is found at once is worth more than one that is a little shorter.
    quick = true;
    suboptimality_bound = 1.2;
  }

  template <class V>
  static void fields(V&& v) {
    v("safety_distance_m", &FlightSearchConfig::safety_distance_m, base::in(0.0, 10.0), "m",
      "every point of the path stays this far from occupied voxels");
    v("max_field_memory_mib", &FlightSearchConfig::max_field_memory_mib, base::in(16.0, 65536.0), "MiB",
      "memory of the clearance field at most");
    PathPlannerConfig::fields(v);
  }

  planning::ClearanceFieldConfig field_config() const {
    planning::ClearanceFieldConfig out;
    out.safety_distance_m = safety_distance_m;
    out.radius_m = std::max(safety_distance_m, clearance_distance_m);
    out.unknown_radius_m = known_distance_m;
    out.unknown_is_flyable = unknown_policy != planning::UnknownPolicy::kForbid;
    out.max_memory_mib = max_field_memory_mib;
    return out;
  }
};

}  // namespace voxnav::bindings
