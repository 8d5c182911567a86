// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav_simulation/avoidance_climb.hpp"
#include "voxnav_simulation/bumper.hpp"
#include "voxnav_simulation/estimator_resets.hpp"
#include "voxnav_simulation/state_noise.hpp"
#include "voxnav_simulation/tracking_response.hpp"
#include "voxnav_simulation/wind.hpp"

namespace voxnav_simulation {

/// Section `refusals`. The MRS MpcTracker says that callbacks are disabled while it brakes into a hover
/// (mrs_uav_trackers/src/mpc_tracker/mpc_tracker.cpp: getStatus, timerHover).
struct RefusalsConfig {
  bool is_enabled = false;

  template <class V>
  static void fields(V&& v) {
    v("is_enabled", &RefusalsConfig::is_enabled, voxnav::base::any(), "",
      "goals and trajectories are refused while the vehicle brakes into a hover");
  }
};

/// Everything that a real vehicle does differently from what it is told; all of it is off by default.
struct UavFaults {
  TrackingConfig tracking;
  WindConfig wind;
  StateNoiseConfig state_noise;
  RefusalsConfig refusals;
  AvoidanceConfig avoidance;
  BumperConfig bumper;
  EstimatorResetsConfig resets;
};

}  // namespace voxnav_simulation
