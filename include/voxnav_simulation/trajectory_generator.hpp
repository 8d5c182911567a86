// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "voxnav_simulation/dynamics_limits.hpp"
#include "voxnav_simulation/kinematic_state.hpp"

namespace voxnav_simulation {

struct TrajectoryGeneratorConfig {
  double sampling_s = 0.2;
  double default_deviation_m = 0.05;
  double limit_ratio = 0.95;
  int max_waypoints = 2000;
  double max_duration_s = 1200.0;
  int max_iterations = 20;

  template <class V>
  static void fields(V&& v) {
    using C = TrajectoryGeneratorConfig;
    using voxnav::base::in;
    v("sampling_s", &C::sampling_s, in(0.02, 1), "s", "time between samples, rounded to 0.01 s");
    v("default_deviation_m", &C::default_deviation_m, in(0.01, 10), "m",
      "deviation from the path when none is asked for");
    v("limit_ratio", &C::limit_ratio, in(0.1, 1), "",
      "share of the limits that is planned with, the rest is for tracking");
    v("max_waypoints", &C::max_waypoints, in(2, 100000), "", "longer paths are refused");
    v("max_duration_s", &C::max_duration_s, in(1, 36000), "s", "slower paths are refused");
    v("max_iterations", &C::max_iterations, in(1, 200), "", "tries to round corners before stopping at each");
  }
};

struct PathRequest {
  std::vector<HeadedPoint> waypoints;
  std::optional<KinematicState> start;  ///< state that the trajectory continues; none: at rest in the first waypoint
  TrackerLimits limits;
  double max_deviation_m = 0;  ///< largest distance from the lines between waypoints; 0 = the configured default
  bool use_heading = true;     ///< whether waypoints' headings are flown; else the start heading is kept
  bool stop_at_waypoints = false;
  bool is_loop = false;                ///< whether the trajectory returns to the first waypoint
  bool has_heading_of_motion = false;  ///< whether the vehicle looks where it flies, not at the waypoints' headings
  bool has_relaxed_heading = false;    ///< whether only the heading of the last waypoint counts
};

struct GeneratedTrajectory {
  bool is_valid = false;
  std::string message;  ///< the reason if there is no trajectory, as text for the operator
  double dt_s = 0;
  double duration_s = 0;
  std::vector<HeadedPoint> samples;           ///< every dt_s; the first is the start, the last is at rest
  std::vector<std::size_t> waypoint_samples;  ///< index of the sample nearest to each waypoint, ascending
  double deviation_m = 0;                     ///< largest distance of the trajectory from the straight lines
  bool stops_at_corners = false;              ///< whether corners could not be rounded within the limits
  int iterations = 0;
};

/// Generates a smooth trajectory through waypoints. Straight lines are flown with a speed profile under limits of speed
/// and tangential acceleration, and the positions are averaged over two windows of time. The first window turns the
/// jumps of velocity at corners into bounded accelerations, the second bounds the jerk. Averages of positions cut
/// corners by an amount proportional to speed, so the speed is lowered wherever deviation, acceleration or jerk exceed
/// their limits. If that does not converge, the vehicle stops at every waypoint, which always respects them.
/// If the start state moves in another direction than the path, the path begins with the distance needed to brake.
/// Deterministic. O(iterations * duration / 0.01 s).
/// Source: moving averages in series as in Biagiotti & Melchiorri, FIR filters for online trajectory planning with
/// time- and frequency-domain specifications, Control Engineering Practice 2012.
GeneratedTrajectory generate_trajectory(const TrajectoryGeneratorConfig& config, const PathRequest& request);

}  // namespace voxnav_simulation
