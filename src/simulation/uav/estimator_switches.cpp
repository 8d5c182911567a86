// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/estimator_switches.hpp"

namespace voxnav_simulation {

EstimatorSwitches::EstimatorSwitches(const EstimatorSwitchesConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)),
      random_(seed, 0x737769746368),
      until_next_s_(random_.exponential(config_.interval_s)) {}

bool EstimatorSwitches::step(double dt_s) {
  if (!config_.is_enabled) return false;
  until_next_s_ -= dt_s;
  if (until_next_s_ > 0) return false;
  until_next_s_ = random_.exponential(config_.interval_s);
  return true;
}

}  // namespace voxnav_simulation
