// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `services`: the simulated time that services take while time runs by itself. A simulation that waits for its
/// nodes has this time pass on the side of the caller (section `work` of the planning manager), as it stands still
/// while the caller waits for an answer.
struct ServiceTimesConfig {
  bool is_enabled = false;
  std::array<double, 2> command_s{0.005, 0.05};
  std::array<double, 2> generator_s{0.05, 0.3};

  template <class V>
  static void fields(V&& v) {
    using C = ServiceTimesConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "",
      "services take simulated time; not for nodes that simulated time waits for");
    v("command_s", &C::command_s, in(0, 5), "s", "least and greatest time until a command is obeyed and answered");
    v("generator_s", &C::generator_s, in(0, 5), "s", "least and greatest time that a trajectory's generation takes");
  }
  std::vector<std::string> problems() const;
};

/// Durations of services, uniformly distributed. Not thread-safe.
class ServiceTimes {
 public:
  /// @throws voxnav::base::ConfigError
  ServiceTimes(const ServiceTimesConfig& config, std::uint64_t seed);

  voxnav::base::StampNs command_ns() { return draw(config_.command_s); }
  voxnav::base::StampNs generator_ns() { return draw(config_.generator_s); }

 private:
  voxnav::base::StampNs draw(const std::array<double, 2>& bounds_s);

  ServiceTimesConfig config_;
  Rng random_;
};

}  // namespace voxnav_simulation
