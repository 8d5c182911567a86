// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/estimator_resets.hpp"

#include <cmath>

namespace voxnav_simulation {

EstimatorResets::EstimatorResets(const EstimatorResetsConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)),
      random_(seed, 0x726573657400),
      until_next_s_(random_.exponential(config_.interval_s)) {}

std::optional<Vec3> EstimatorResets::step(double dt_s) {
  if (!config_.is_enabled) return std::nullopt;
  until_next_s_ -= dt_s;
  if (until_next_s_ > 0) return std::nullopt;
  until_next_s_ = random_.exponential(config_.interval_s);
  const double direction_rad = random_.uniform(0, 2.0 * M_PI);
  return config_.jump_m * Vec3(std::cos(direction_rad), std::sin(direction_rad), 0);
}

}  // namespace voxnav_simulation
