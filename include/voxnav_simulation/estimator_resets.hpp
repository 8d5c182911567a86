// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `resets`. When the MRS estimation manager resets or switches its estimator, the frame of the estimate jumps,
/// estimator_iteration of mrs_msgs/UavState is counted up, and the tracker moves its state and its references along
/// (mrs_uav_trackers/src/mpc_tracker/mpc_tracker.cpp: switchOdometrySource).
struct EstimatorResetsConfig {
  bool is_enabled = false;
  double interval_s = 90.0;
  double jump_m = 0.5;

  template <class V>
  static void fields(V&& v) {
    using C = EstimatorResetsConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "", "at times the estimator is reset, and its frame jumps");
    v("interval_s", &C::interval_s, in(1, 3600), "s", "mean time between resets, which come at random");
    v("jump_m", &C::jump_m, in(0, 100), "m", "length of a jump, whose horizontal direction is random");
  }
};

/// The moments at which the frame of the estimate jumps.
class EstimatorResets {
 public:
  /// @throws voxnav::base::ConfigError
  EstimatorResets(const EstimatorResetsConfig& config, std::uint64_t seed);

  /// Returns the jump of estimated positions if this step of a flying vehicle resets the estimator.
  std::optional<Vec3> step(double dt_s);

 private:
  EstimatorResetsConfig config_;
  Rng random_;
  double until_next_s_;
};

}  // namespace voxnav_simulation
