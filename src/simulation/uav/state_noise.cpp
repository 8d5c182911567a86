// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/state_noise.hpp"

#include "voxnav_simulation/ornstein_uhlenbeck.hpp"

namespace voxnav_simulation {

StateNoise::StateNoise(const StateNoiseConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), random_(seed, 0x6e6f69736500) {}

void StateNoise::step(double dt_s) {
  if (!config_.is_enabled) return;
  step_ornstein_uhlenbeck(Vec3::Constant(config_.position_m), dt_s / config_.time_s, &random_, &position_);
  step_ornstein_uhlenbeck(Vec3::Constant(config_.velocity_mps), dt_s / config_.time_s, &random_, &velocity_);
}

}  // namespace voxnav_simulation
