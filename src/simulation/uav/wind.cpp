// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/wind.hpp"

#include "voxnav_simulation/ornstein_uhlenbeck.hpp"

namespace voxnav_simulation {

Wind::Wind(const WindConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), random_(seed, 0x77696e6400) {}

void Wind::step(double dt_s) {
  if (!config_.is_enabled) return;
  const Vec3 sigma(config_.gust_mps, config_.gust_mps, config_.vertical_gust_mps);
  step_ornstein_uhlenbeck(sigma, dt_s / config_.gust_time_s, &random_, &gust_);
  velocity_ = Vec3(config_.mean_mps[0], config_.mean_mps[1], 0) + gust_;
}

}  // namespace voxnav_simulation
