// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/kinematic_state.hpp"

#include <cmath>

namespace voxnav_simulation {

bool is_finite(const HeadedPoint& point) { return point.position.allFinite() && std::isfinite(point.heading_rad); }

bool is_finite(const KinematicState& s) {
  return s.position.allFinite() && s.velocity.allFinite() && s.acceleration.allFinite() && s.jerk.allFinite() &&
         std::isfinite(s.heading_rad + s.heading_rate + s.heading_acceleration + s.heading_jerk);
}

}  // namespace voxnav_simulation
