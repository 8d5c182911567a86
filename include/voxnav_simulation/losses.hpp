// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/config.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `losses`: the shares of messages that are lost on their way, each for itself. What a simulation waits for at
/// an instant at which time stands still is never lost then, because it would wait for ever.
struct LossesConfig {
  bool is_enabled = false;
  double odometry_ratio = 0.02;
  double diagnostics_ratio = 0.1;

  template <class V>
  static void fields(V&& v) {
    using C = LossesConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "", "messages are lost");
    v("odometry_ratio", &C::odometry_ratio, in(0, 1), "",
      "share of lost uav_state, odom_main, tf and tracker_cmd, each for itself");
    v("diagnostics_ratio", &C::diagnostics_ratio, in(0, 1), "",
      "share of lost diagnostics and constraints of the MRS nodes, each for itself");
  }
};

/// Returns whether a message is lost, which follows from the seed, its stream and its stamp alone.
inline bool is_lost(double ratio, std::uint64_t seed, std::uint64_t stream, voxnav::base::StampNs stamp_ns) {
  if (ratio <= 0.0) return false;
  return Rng(mix_bits(seed) ^ static_cast<std::uint64_t>(stamp_ns), stream).uniform() < ratio;
}

}  // namespace voxnav_simulation
