// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Parameters of the planning_manager node for other UAVs, which announce where they will be.
struct OtherUavsConfig {
  std::vector<std::string> robot_names;
  std::string topic = "control_manager/mpc_tracker/predicted_trajectory";
  double step_s = 0.2;
  double max_delay_s = 0.5;
  double max_transform_age_s = 10.0;
  bool must_be_heard = false;
  double body_radius_m = 0.5;
  double position_error_m = 1.5;
  double growth_mps = 0.2;
  double late_growth_mps = 1.0;
  double silent_after_s = 1.5;
  double silent_growth_mps = 1.0;
  double max_growth_m = 5.0;
  double forget_after_s = 60.0;
  double horizon_s = 8.0;
  double near_horizon_s = 2.5;

  template <class V>
  static void fields(V&& v) {
    using C = OtherUavsConfig;
    using base::in;
    v("robot_names", &C::robot_names, base::any(), "",
      "names of the UAVs that fly here, with or without this one; empty = network/robot_names of MRS's network_config");
    v("topic", &C::topic, base::any(), "", "their predicted trajectories (mrs_msgs/FutureTrajectory), in /NAME/");
    v("step_s", &C::step_s, in(0.01, 2.0), "s", "time between the places of a predicted trajectory");
    v("max_delay_s", &C::max_delay_s, in(0.0, 5.0), "s",
      "messages are not older than this; a stamp that tells otherwise is of another clock, and the time of arrival "
      "counts");
    v("max_transform_age_s", &C::max_transform_age_s, in(0.1, 3600.0), "s",
      "the transform from UTM holds for this long after tf told it last; then it is not known where they are. Static "
      "transforms hold for ever");
    v("must_be_heard", &C::must_be_heard, base::any(), "",
      "nothing is flown until each of them was heard; false: that is only told");
    v("body_radius_m", &C::body_radius_m, in(0.05, 10.0), "m", "the body of a UAV is this near to its position");
    v("position_error_m", &C::position_error_m, in(0.0, 20.0), "m",
      "greatest error of another position relative to that of this vehicle: of both estimators");
    v("growth_mps", &C::growth_mps, in(0.0, 5.0), "m/s",
      "the room that it may need grows by this along its prediction");
    v("late_growth_mps", &C::late_growth_mps, in(0.0, 10.0), "m/s", "and by this in addition after its end");
    v("silent_after_s", &C::silent_after_s, in(0.2, 60.0), "s", "one that was not heard for this long is silent");
    v("silent_growth_mps", &C::silent_growth_mps, in(0.0, 10.0), "m/s",
      "the room around a silent one grows by this, since it may have changed its way");
    v("max_growth_m", &C::max_growth_m, in(0.0, 100.0), "m", "the room grows by no more than this");
    v("forget_after_s", &C::forget_after_s, in(0.0, 86400.0), "s",
      "one that is silent for this long has landed, or only the sensors tell where it is; 0 = it is never forgotten");
    v("horizon_s", &C::horizon_s, in(0.5, 30.0), "s",
      "those that have the right of way are kept clear of for this time");
    v("near_horizon_s", &C::near_horizon_s, in(0.5, 30.0), "s",
      "those that give way are kept clear of for this time, unless they are at rest");
  }
  std::vector<std::string> problems() const {
    if (near_horizon_s <= horizon_s) return {};
    return {"near_horizon_s must not exceed horizon_s"};
  }
};

}  // namespace voxnav::bindings
