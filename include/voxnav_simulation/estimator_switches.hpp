// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `switches`. The MRS estimation manager runs several estimators at once, each with an origin of its own on
/// tf, and switches between them by itself or by its service change_estimator. Then everything that is expressed in the
/// control frame has the other origin from one message to the next
/// (mrs_uav_managers/src/estimation_manager/estimation_manager.cpp: switchToEstimator).
struct EstimatorSwitchesConfig {
  bool is_enabled = false;
  double interval_s = 120.0;
  std::string estimator = "gps_baro";
  std::array<double, 3> offset_m{3.0, -2.0, 1.0};
  double offset_heading_rad = 0.3;

  template <class V>
  static void fields(V&& v) {
    using C = EstimatorSwitchesConfig;
    using voxnav::base::any;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, any(), "",
      "in flight the estimator is switched at times; otherwise only by estimation_manager/change_estimator");
    v("interval_s", &C::interval_s, in(1, 3600), "s", "mean time between switches, which come at random");
    v("estimator", &C::estimator, any(), "", "name of the second estimator, which always runs beside the first");
    v("offset_m", &C::offset_m, in(-1e4, 1e4), "m", "where its origin is in the frame of the first one");
    v("offset_heading_rad", &C::offset_heading_rad, in(-3.2, 3.2), "rad", "heading of its origin there");
  }
};

/// The moments at which the estimator is switched.
class EstimatorSwitches {
 public:
  /// @throws voxnav::base::ConfigError
  EstimatorSwitches(const EstimatorSwitchesConfig& config, std::uint64_t seed);

  /// Returns true if this step of a flying vehicle switches the estimator.
  bool step(double dt_s);

 private:
  EstimatorSwitchesConfig config_;
  Rng random_;
  double until_next_s_;
};

}  // namespace voxnav_simulation
