// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `wind`. The defaults are those of light turbulence near the ground: with 15 knots of wind at 20 feet and a
/// height of 3 m, MIL-F-8785C (section 3.7.3.4) gives gusts of 1.5 m/s along and across and of 0.8 m/s vertically,
/// whose scale length of 23 m passes a vehicle in about 4 s. Between trees the mean is less than at 20 feet.
struct WindConfig {
  bool is_enabled = false;
  std::array<double, 2> mean_mps{2.0, 1.0};
  double gust_mps = 1.5;
  double vertical_gust_mps = 0.8;
  double gust_time_s = 4.0;

  template <class V>
  static void fields(V&& v) {
    using C = WindConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "", "wind pushes the vehicle");
    v("mean_mps", &C::mean_mps, in(-30, 30), "m/s", "mean wind along x and y of the world");
    v("gust_mps", &C::gust_mps, in(0, 20), "m/s", "standard deviation of horizontal gusts, per axis");
    v("vertical_gust_mps", &C::vertical_gust_mps, in(0, 20), "m/s", "standard deviation of vertical gusts");
    v("gust_time_s", &C::gust_time_s, in(0.1, 60), "s", "time over which gusts change");
  }
};

/// The velocity of the air: a mean and gusts, each axis of which is a stationary Ornstein-Uhlenbeck process. That is
/// the Dryden spectrum along the wind (MIL-F-8785C, section 3.7.1.2), used for all three axes.
class Wind {
 public:
  /// @throws voxnav::base::ConfigError
  Wind(const WindConfig& config, std::uint64_t seed);

  void step(double dt_s);
  /// Velocity of the air in W in m/s; zero without wind.
  Vec3 velocity() const { return velocity_; }

 private:
  WindConfig config_;
  Rng random_;
  Vec3 gust_ = Vec3::Zero();
  Vec3 velocity_ = Vec3::Zero();
};

}  // namespace voxnav_simulation
