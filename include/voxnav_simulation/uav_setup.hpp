// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav_simulation/dynamics_limits.hpp"
#include "voxnav_simulation/gnss_drift.hpp"
#include "voxnav_simulation/imu_model.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/uav_faults.hpp"

namespace voxnav_simulation {

struct UavConfig {
  std::array<double, 2> start_m{0.0, 0.0};
  double start_heading_rad = 0.0;
  double standing_height_m = 0.25;
  double take_off_height_m = 2.0;
  double rangefinder_max_m = 40.0;
  double rangefinder_noise_m = 0.02;

  template <class V>
  static void fields(V&& v) {
    using C = UavConfig;
    using voxnav::base::in;
    v("start_m", &C::start_m, in(-5000, 5000), "m", "where the vehicle stands at first");
    v("start_heading_rad", &C::start_heading_rad, in(-6.3, 6.3), "rad", "its heading at first");
    v("standing_height_m", &C::standing_height_m, in(0, 2), "m", "body origin above the ground when standing");
    v("take_off_height_m", &C::take_off_height_m, in(0.5, 50), "m", "height above the ground that take-off ends at");
    v("rangefinder_max_m", &C::rangefinder_max_m, in(1, 500), "m", "the rangefinder sees nothing farther away");
    v("rangefinder_noise_m", &C::rangefinder_noise_m, in(0, 1), "m", "standard deviation of a range");
  }
};

enum class FlightPhase { kIdle, kTakingOff, kFlying, kLanding };

/// Which controller flies: in emergencies the control manager activates another one than in normal flight.
enum class ActiveController { kNormal, kEmergency, kFailsafe };

/// The pose and motion of the body in one frame.
struct BodyState {
  Pose pose = Pose::Identity();          ///< body B in the frame
  Vec3 velocity = Vec3::Zero();          ///< of B, in the frame
  Vec3 acceleration = Vec3::Zero();      ///< of B, in the frame
  Vec3 angular_velocity = Vec3::Zero();  ///< in B
};

struct CommandResult {
  bool success = false;
  std::string message;
};

/// The parts of a simulated vehicle.
struct UavSetup {
  UavConfig uav;
  GnssDriftConfig drift;
  ImuConfig imu;
  TrackerLimits limits = limits_of(UavConstraintsConfig{}, ConstraintSet::kMedium);
  UavFaults faults;
};

}  // namespace voxnav_simulation
