// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Parameters of the planning_manager node around the planning manager: frames, rates, services and heartbeats.
struct PlanningNodeConfig {
  std::string map_frame = "map";
  bool use_map_correction = true;
  std::vector<std::string> required_nodes = {"cloud_filter", "local_mapper", "submap_integrator", "submap_optimizer"};
  double heartbeat_timeout_s = 4.0;
  double main_rate_hz = 20.0;
  double check_rate_hz = 10.0;
  double status_rate_hz = 5.0;
  double service_timeout_s = 2.0;
  double hover_timeout_s = 0.5;
  double generator_time_s = 0.3;
  bool keep_goal_over_restart = true;
  bool validate_goals = true;

  template <class V>
  static void fields(V&& v) {
    using C = PlanningNodeConfig;
    using base::in;
    v("map_frame", &C::map_frame, base::any(), "", "frame W, until the optimiser names it");
    v("use_map_correction", &C::use_map_correction, base::any(), "",
      "false: there is no optimiser, W is the odometry frame");
    v("required_nodes", &C::required_nodes, base::any(), "",
      "nodes whose diagnostics must be heard; the vehicle hovers without them");
    v("heartbeat_timeout_s", &C::heartbeat_timeout_s, in(1.5, 60), "s",
      "time without diagnostics after which a node counts as lost");
    v("main_rate_hz", &C::main_rate_hz, in(1, 200), "Hz", "rate of the main loop");
    v("check_rate_hz", &C::check_rate_hz, in(1, 100), "Hz", "rate of the corridor check");
    v("status_rate_hz", &C::status_rate_hz, in(0.1, 50), "Hz", "rate of status and markers");
    v("service_timeout_s", &C::service_timeout_s, in(0.1, 30), "s", "time within which a service must answer");
    v("hover_timeout_s", &C::hover_timeout_s, in(0.05, 10), "s",
      "time within which a hover must be answered; then ehover is called");
    v("generator_time_s", &C::generator_time_s, in(0.01, 10), "s", "solver time requested of the trajectory generator");
    v("keep_goal_over_restart", &C::keep_goal_over_restart, base::any(), "",
      "a restarted node takes up the goal that it was flying to");
    v("validate_goals", &C::validate_goals, base::any(), "",
      "each new goal is shown to validate_reference of the control manager, and dropped if that refuses it");
  }
};

}  // namespace voxnav::bindings
