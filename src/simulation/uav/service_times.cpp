// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/service_times.hpp"

namespace voxnav_simulation {

std::vector<std::string> ServiceTimesConfig::problems() const {
  std::vector<std::string> out;
  if (command_s[0] > command_s[1]) out.emplace_back("command_s: the least time must not exceed the greatest");
  if (generator_s[0] > generator_s[1]) out.emplace_back("generator_s: the least time must not exceed the greatest");
  return out;
}

ServiceTimes::ServiceTimes(const ServiceTimesConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), random_(seed, 0x7365727600) {}

voxnav::base::StampNs ServiceTimes::draw(const std::array<double, 2>& bounds_s) {
  if (!config_.is_enabled) return 0;
  return voxnav::base::from_seconds(random_.uniform(bounds_s[0], bounds_s[1]));
}

}  // namespace voxnav_simulation
