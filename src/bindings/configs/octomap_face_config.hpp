// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Parameters of the node octomap_server, which stands in for mrs_octomap_server.
struct OctomapServerConfig {
  std::string map_frame = "map";
  std::string body_frame = "fcu";
  std::string map_path = "~/maps";
  std::string map_name = "default";
  bool loads_at_start = false;
  double autosave_period_s = 0.0;
  double service_timeout_s = 60.0;
  bool aligns_altitude = false;
  double ground_distance_m = 2.0;
  double robot_height_m = 0.3;
  double input_timeout_s = 1.0;

  template <class V>
  static void fields(V&& v) {
    using C = OctomapServerConfig;
    using base::in;
    v("map_frame", &C::map_frame, base::any(), "", "frame W, in which maps are saved");
    v("body_frame", &C::body_frame, base::any(), "", "frame B of the UAV");
    v("map_path", &C::map_path, base::any(), "", "folder of the maps; ~ is the home folder");
    v("map_name", &C::map_name, base::any(), "", "name of the map that is loaded at the start and saved in flight");
    v("loads_at_start", &C::loads_at_start, base::any(), "", "loads that map at the start, if there is one");
    v("autosave_period_s", &C::autosave_period_s, in(0.0, 3600.0), "s",
      "the map is saved this often in flight, with one backup; 0 = never");
    v("service_timeout_s", &C::service_timeout_s, in(0.1, 600.0), "s",
      "time within which a map must be saved or loaded");
    v("aligns_altitude", &C::aligns_altitude, base::any(), "",
      "a map that is loaded is moved up or down until its ground lies below the vehicle");
    v("ground_distance_m", &C::ground_distance_m, in(0.5, 20.0), "m",
      "the ground is looked for this far around the vehicle, horizontally");
    v("robot_height_m", &C::robot_height_m, in(0.0, 5.0), "m", "height of the body frame of a vehicle that stands");
    v("input_timeout_s", &C::input_timeout_s, in(0.1, 10.0), "s", "older odometry, heights and diagnostics are lost");
  }
};

/// Parameters of the node octomap_planner, which stands in for mrs_octomap_planner.
struct OctomapPlannerConfig {
  double min_safety_distance_m = 0.6;
  double max_safety_distance_m = 5.0;
  double diagnostics_rate_hz = 10.0;
  double service_timeout_s = 5.0;
  double status_timeout_s = 2.0;

  template <class V>
  static void fields(V&& v) {
    using C = OctomapPlannerConfig;
    using base::in;
    v("min_safety_distance_m", &C::min_safety_distance_m, in(0.0, 10.0), "m", "least distance that ~distance accepts");
    v("max_safety_distance_m", &C::max_safety_distance_m, in(0.0, 10.0), "m",
      "greatest distance that ~distance accepts");
    v("diagnostics_rate_hz", &C::diagnostics_rate_hz, in(0.1, 100.0), "Hz", "rate of ~mrs_diagnostics_out");
    v("service_timeout_s", &C::service_timeout_s, in(0.1, 60.0), "s",
      "time within which the planning manager must answer");
    v("status_timeout_s", &C::status_timeout_s, in(0.5, 60.0), "s",
      "an older status of the planning manager is no reason to say anything");
  }
  std::vector<std::string> problems() const {
    if (min_safety_distance_m < max_safety_distance_m) return {};
    return {"min_safety_distance_m must be below max_safety_distance_m"};
  }
};

/// Parameters of the node bumper, beside its sectors.
struct BumperNodeConfig {
  std::string frame = "fcu_untilted";
  double rate_hz = 10.0;
  double timeout_s = 1.0;
  double service_timeout_s = 2.0;

  template <class V>
  static void fields(V&& v) {
    using C = BumperNodeConfig;
    using base::in;
    v("frame", &C::frame, base::any(), "", "frame of the sectors: the body without roll and pitch");
    v("rate_hz", &C::rate_hz, in(1.0, 100.0), "Hz", "rate of the sectors");
    v("timeout_s", &C::timeout_s, in(0.1, 10.0), "s",
      "with an older map or odometry all sectors are without data; they are published nevertheless");
    v("service_timeout_s", &C::service_timeout_s, in(0.1, 30.0), "s", "time within which a whole map must come");
  }
};

/// Which headings trajectories have.
enum class HeadingMode { kGoal, kFlightDirection, kFixed };
constexpr auto words_of(HeadingMode) { return std::array{"goal", "flight_direction", "fixed"}; }

/// Section `heading` of the planning_manager node.
struct HeadingConfig {
  HeadingMode mode = HeadingMode::kGoal;
  double offset_rad = 0.0;
  bool is_relaxed = true;
  double look_ahead_m = 1.0;

  template <class V>
  static void fields(V&& v) {
    using C = HeadingConfig;
    using base::in;
    v("mode", &C::mode, base::one_of<HeadingMode>(), "",
      "goal: free on the way, and that of the goal there, if it has one; flight_direction: along the path; fixed: as "
      "it is");
    v("offset_rad", &C::offset_rad, in(-3.1416, 3.1416), "rad",
      "added to the direction of flight, for a sensor that does not look ahead");
    v("is_relaxed", &C::is_relaxed, base::any(), "",
      "the flight is not slowed down for turns along the path; the tracker turns as fast as it may");
    v("look_ahead_m", &C::look_ahead_m, in(0.1, 20.0), "m",
      "the direction of flight is that to the path this far ahead, so that small bends cause no turns");
  }
};

}  // namespace voxnav::bindings
