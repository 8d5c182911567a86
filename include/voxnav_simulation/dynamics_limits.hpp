// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav_simulation {

/// Largest speed, acceleration and jerk of one axis, in m or rad.
struct TrackerAxisLimits {
  double speed;
  double acceleration;
  double jerk;
};

/// The limits of the vehicle's motion. Horizontal limits hold for the norm of the x-y vector.
struct TrackerLimits {
  TrackerAxisLimits horizontal;
  TrackerAxisLimits ascending;
  TrackerAxisLimits descending;
  TrackerAxisLimits heading;

  /// Returns the smaller of the limits upwards and downwards, which can be used without knowing the direction.
  double vertical_acceleration() const;
  double vertical_jerk() const;
  /// Returns these limits with every number multiplied by `ratio`.
  TrackerLimits scaled(double ratio) const;
};

/// Named sets of limits, between which the MRS constraint manager switches.
enum class ConstraintSet { kSlow, kMedium, kFast };
constexpr auto words_of(ConstraintSet) { return std::array{"slow", "medium", "fast"}; }

/// The limits of each set. Each array holds speed, acceleration and jerk in this order.
struct UavConstraintsConfig {
  ConstraintSet initial = ConstraintSet::kMedium;
  double max_speed_mps = 8.0;
  std::array<double, 3> slow_horizontal{1, 1, 20};
  std::array<double, 3> slow_vertical{1, 1, 20};
  std::array<double, 3> slow_heading{0.5, 1, 10};
  std::array<double, 3> medium_horizontal{4, 2, 40};
  std::array<double, 3> medium_vertical{2, 1, 40};
  std::array<double, 3> medium_heading{1, 1, 20};
  std::array<double, 3> fast_horizontal{8, 4, 60};
  std::array<double, 3> fast_vertical{4, 2, 60};
  std::array<double, 3> fast_heading{2, 2, 40};

  template <class V>
  static void fields(V&& v) {
    using C = UavConstraintsConfig;
    const auto range = voxnav::base::in(0.05, 200);
    v("initial", &C::initial, voxnav::base::one_of<ConstraintSet>(), "", "set in force at the start");
    v("max_speed_mps", &C::max_speed_mps, range, "m/s", "the horizontal speed of every set is limited to this");
    v("slow_horizontal", &C::slow_horizontal, range, "m/s, m/s^2, m/s^3", "horizontal limits of the set slow");
    v("slow_vertical", &C::slow_vertical, range, "m/s, m/s^2, m/s^3", "vertical limits of the set slow");
    v("slow_heading", &C::slow_heading, range, "rad/s, rad/s^2, rad/s^3", "heading limits of the set slow");
    v("medium_horizontal", &C::medium_horizontal, range, "m/s, m/s^2, m/s^3", "horizontal limits of the set medium");
    v("medium_vertical", &C::medium_vertical, range, "m/s, m/s^2, m/s^3", "vertical limits of the set medium");
    v("medium_heading", &C::medium_heading, range, "rad/s, rad/s^2, rad/s^3", "heading limits of the set medium");
    v("fast_horizontal", &C::fast_horizontal, range, "m/s, m/s^2, m/s^3", "horizontal limits of the set fast");
    v("fast_vertical", &C::fast_vertical, range, "m/s, m/s^2, m/s^3", "vertical limits of the set fast");
    v("fast_heading", &C::fast_heading, range, "rad/s, rad/s^2, rad/s^3", "heading limits of the set fast");
  }
  std::vector<std::string> problems() const;
};

/// Returns the limits of a set, with its horizontal speed limited to max_speed_mps.
TrackerLimits limits_of(const UavConstraintsConfig& config, ConstraintSet set);

}  // namespace voxnav_simulation
