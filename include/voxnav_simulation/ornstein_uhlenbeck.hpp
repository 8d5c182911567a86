// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>

#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Advances three independent Ornstein-Uhlenbeck processes by one step, exactly for any length of it. Their stationary
/// standard deviations are `sigma`.
/// Source: Gillespie, Exact numerical simulation of the Ornstein-Uhlenbeck process and its integral, Phys. Rev. E 54,
/// 1996, eq. 1.9.
inline void step_ornstein_uhlenbeck(const Vec3& sigma, double step_over_time, Rng* random, Vec3* state) {
  const double kept = std::exp(-step_over_time), added = std::sqrt(1.0 - kept * kept);
  for (int i = 0; i < 3; ++i) (*state)[i] = kept * (*state)[i] + added * sigma[i] * random->normal();
}

}  // namespace voxnav_simulation
