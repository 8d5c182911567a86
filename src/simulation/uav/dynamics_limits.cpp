// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/dynamics_limits.hpp"

#include <algorithm>
#include <stdexcept>

namespace voxnav_simulation {
namespace {

TrackerAxisLimits axis_of(const std::array<double, 3>& values) { return {values[0], values[1], values[2]}; }

TrackerAxisLimits scaled_axis(const TrackerAxisLimits& limits, double ratio) {
  return {limits.speed * ratio, limits.acceleration * ratio, limits.jerk * ratio};
}

TrackerLimits set_of(const std::array<double, 3>& horizontal, const std::array<double, 3>& vertical,
                     const std::array<double, 3>& heading) {
  return {axis_of(horizontal), axis_of(vertical), axis_of(vertical), axis_of(heading)};
}

TrackerLimits uncapped(const UavConstraintsConfig& config, ConstraintSet set) {
  switch (set) {
    case ConstraintSet::kSlow:
      return set_of(config.slow_horizontal, config.slow_vertical, config.slow_heading);
    case ConstraintSet::kMedium:
      return set_of(config.medium_horizontal, config.medium_vertical, config.medium_heading);
    case ConstraintSet::kFast:
      return set_of(config.fast_horizontal, config.fast_vertical, config.fast_heading);
  }
  throw std::invalid_argument("no such set of constraints");
}

}  // namespace

double TrackerLimits::vertical_acceleration() const {
  return std::min(ascending.acceleration, descending.acceleration);
}

double TrackerLimits::vertical_jerk() const { return std::min(ascending.jerk, descending.jerk); }

TrackerLimits TrackerLimits::scaled(double ratio) const {
  return {scaled_axis(horizontal, ratio), scaled_axis(ascending, ratio), scaled_axis(descending, ratio),
          scaled_axis(heading, ratio)};
}

std::vector<std::string> UavConstraintsConfig::problems() const {
  if (max_speed_mps <= fast_horizontal[0]) return {};
  return {"max_speed_mps must not exceed the speed of the set fast, as no set would announce it"};
}

TrackerLimits limits_of(const UavConstraintsConfig& config, ConstraintSet set) {
  TrackerLimits out = uncapped(config, set);
  out.horizontal.speed = std::min(out.horizontal.speed, config.max_speed_mps);
  return out;
}

}  // namespace voxnav_simulation
