// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `state_noise`: errors of the estimated state beside its drift, of the size that a filter of GNSS and IMU
/// leaves from one moment to the next.
struct StateNoiseConfig {
  bool is_enabled = false;
  double position_m = 0.03;
  double velocity_mps = 0.1;
  double time_s = 0.5;

  template <class V>
  static void fields(V&& v) {
    using C = StateNoiseConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "", "the estimated state is noisy");
    v("position_m", &C::position_m, in(0, 5), "m", "standard deviation of the estimated position, per axis");
    v("velocity_mps", &C::velocity_mps, in(0, 5), "m/s", "standard deviation of the estimated velocity, per axis");
    v("time_s", &C::time_s, in(0.01, 60), "s", "time over which these errors change");
  }
};

/// Errors of estimated position and velocity: stationary Ornstein-Uhlenbeck processes, independent for each axis.
class StateNoise {
 public:
  /// @throws voxnav::base::ConfigError
  StateNoise(const StateNoiseConfig& config, std::uint64_t seed);

  void step(double dt_s);
  const Vec3& position() const { return position_; }
  const Vec3& velocity() const { return velocity_; }

 private:
  StateNoiseConfig config_;
  Rng random_;
  Vec3 position_ = Vec3::Zero();
  Vec3 velocity_ = Vec3::Zero();
};

}  // namespace voxnav_simulation
