// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// Parameters of the way home in the planning_manager node: which goals the battery allows.
struct HomeConfig {
  double full_flight_time_s = 0.0;
  double reserve_s = 60.0;
  double detour_ratio = 1.3;
  double battery_timeout_s = 10.0;
  bool return_at_reserve = false;

  template <class V>
  static void fields(V&& v) {
    using C = HomeConfig;
    using base::in;
    v("full_flight_time_s", &C::full_flight_time_s, in(0, 100000), "s",
      "flight time of a full battery; goals whose way there and back takes more than the rest of it are refused; 0 = "
      "no "
      "goal is refused because of the battery");
    v("reserve_s", &C::reserve_s, in(0, 10000), "s", "flight time that must be left after the way there and back");
    v("detour_ratio", &C::detour_ratio, in(1, 10), "",
      "ways are this much longer than the straight line, as estimated");
    v("battery_timeout_s", &C::battery_timeout_s, in(0.5, 600), "s", "an older state of the battery is not known");
    v("return_at_reserve", &C::return_at_reserve, base::any(), "",
      "when the battery no longer holds for more than the way home and the reserve, the start becomes the goal, once "
      "in "
      "a flight; false: that is only told");
  }
};

}  // namespace voxnav::bindings
