// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <optional>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Section `avoidance`. The MRS MpcTracker flies over another UAV that comes near: it raises its reference to 3 m above
/// the other, slows down to a quarter horizontally, and afterwards lets the height sink back by 2 m/s
/// (mrs_uav_trackers/config/public/mpc_tracker.yaml: correction; config/private/mpc_tracker.yaml:
/// collision_horizontal_speed_coef; src/mpc_tracker/mpc_tracker.cpp: checkTrajectoryForCollisions). The trajectory goes
/// on meanwhile, and nothing is disabled.
struct AvoidanceConfig {
  bool is_enabled = false;
  double interval_s = 60.0;
  double duration_s = 4.0;
  double correction_m = 3.0;
  double speed_ratio = 0.25;
  double descent_mps = 2.0;
  double headroom_m = 1.5;

  template <class V>
  static void fields(V&& v) {
    using C = AvoidanceConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "",
      "at times the tracker avoids an imagined UAV by climbing over it");
    v("interval_s", &C::interval_s, in(1, 3600), "s", "mean time between such encounters, which come at random");
    v("duration_s", &C::duration_s, in(0.1, 600), "s", "time that the other UAV stays");
    v("correction_m", &C::correction_m, in(0.1, 50), "m", "height of the climb");
    v("speed_ratio", &C::speed_ratio, in(0.01, 1), "", "share of the horizontal speed limit that is left meanwhile");
    v("descent_mps", &C::descent_mps, in(0.1, 10), "m/s", "speed at which the least height sinks back afterwards");
    v("headroom_m", &C::headroom_m, in(0, 20), "m",
      "another UAV only comes where the way up keeps this distance from surfaces");
  }
};

/// The encounters with other UAVs, which give the tracker a least height for a while.
class AvoidanceClimb {
 public:
  /// Returns whether the vehicle could climb from here by the correction; called at the time of an encounter.
  using HasRoom = std::function<bool()>;

  /// @throws voxnav::base::ConfigError
  AvoidanceClimb(const AvoidanceConfig& config, std::uint64_t seed);

  /// Makes a step of a flying vehicle at height z_m.
  void step(double dt_s, double z_m, const HasRoom& has_room);
  /// Forgets a present encounter, as on the ground.
  void end() { floor_m_.reset(); }
  void shift(double jump_m) {
    if (floor_m_) *floor_m_ += jump_m, begin_m_ += jump_m;
  }

  /// The least height of the tracker's reference; nothing while no other UAV is near.
  std::optional<double> floor_m() const { return floor_m_; }
  double speed_ratio() const { return floor_m_ ? config_.speed_ratio : 1.0; }

 private:
  AvoidanceConfig config_;
  Rng random_;
  double until_next_s_;
  double remaining_s_ = 0;  ///< time that the other UAV stays
  double begin_m_ = 0;      ///< height at the begin of the encounter
  std::optional<double> floor_m_;
};

}  // namespace voxnav_simulation
