// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/kinematic_state.hpp"

namespace voxnav_simulation {

/// Section `tracking`. The gains are the set `soft` of the MRS system, which it uses with GNSS
/// (mrs_uav_managers/config/public/gain_manager/gains.yaml); a gain of attitude of 5 makes tilt follow within 0.2 s.
/// Delay and drag are typical of a multirotor of 2 kg.
struct TrackingConfig {
  bool is_enabled = false;
  double horizontal_position_gain = 6.0;
  double horizontal_velocity_gain = 4.0;
  double vertical_position_gain = 15.0;
  double vertical_velocity_gain = 8.0;
  double disturbance_gain = 0.1;
  double tilt_time_s = 0.2;
  double thrust_time_s = 0.05;
  double delay_s = 0.05;
  double drag = 0.2;

  template <class V>
  static void fields(V&& v) {
    using C = TrackingConfig;
    using voxnav::base::in;
    v("is_enabled", &C::is_enabled, voxnav::base::any(), "",
      "the vehicle follows the tracker as a feedback controller lets it; false: exactly");
    v("horizontal_position_gain", &C::horizontal_position_gain, in(0.1, 50), "1/s^2", "kp of the controller");
    v("horizontal_velocity_gain", &C::horizontal_velocity_gain, in(0.1, 50), "1/s", "kv of the controller");
    v("vertical_position_gain", &C::vertical_position_gain, in(0.1, 50), "1/s^2", "kp of the controller in height");
    v("vertical_velocity_gain", &C::vertical_velocity_gain, in(0.1, 50), "1/s", "kv of the controller in height");
    v("disturbance_gain", &C::disturbance_gain, in(0, 10), "1/s^3", "kiw of the controller, which learns steady wind");
    v("tilt_time_s", &C::tilt_time_s, in(0.005, 2), "s", "time constant with which the vehicle tilts");
    v("thrust_time_s", &C::thrust_time_s, in(0.005, 2), "s", "time constant of its thrust");
    v("delay_s", &C::delay_s, in(0, 0.5), "s", "delay from the state to the command of the controller");
    v("drag", &C::drag, in(0, 5), "1/s", "deceleration by air over the speed through it");
  }
  std::vector<std::string> problems() const;
};

/// The motion of a vehicle whose controller follows a reference. The controller adds feedback on position and velocity
/// to the acceleration of the reference and learns steady disturbances; its command takes effect after a delay and
/// through the lags of tilt and thrust, while air resists. So the vehicle lags behind, cuts corners and overshoots.
/// Source of the controller's form: Lee, Leok & McClamroch, Geometric tracking control of a quadrotor UAV on SE(3), CDC
/// 2010, section IV (position loop).
class TrackingResponse {
 public:
  /// @param is_exact  whether command and motion agree at once, without delay and lags; air resists all the same
  /// @throws voxnav::base::ConfigError
  TrackingResponse(const TrackingConfig& config, bool is_exact);

  /// Puts the vehicle onto the reference.
  void reset(const KinematicState& reference);
  /// Moves everything by a jump of the frame.
  void shift(const Vec3& jump);
  /// Makes a step. `air_velocity` is in the frame of the reference.
  void step(const KinematicState& reference, const Vec3& air_velocity, double dt_s);

  const Vec3& position() const { return position_; }
  const Vec3& velocity() const { return velocity_; }
  Vec3 acceleration() const { return thrust_ + resistance_; }
  /// The acceleration that thrust gives beyond holding the weight, by which the vehicle is tilted.
  const Vec3& thrust() const { return thrust_; }

 private:
  Vec3 command(const KinematicState& reference, double dt_s);

  TrackingConfig config_;
  bool is_exact_;
  std::deque<Vec3> delayed_;  ///< commands that have not taken effect yet, oldest first
  Vec3 position_ = Vec3::Zero();
  Vec3 velocity_ = Vec3::Zero();
  Vec3 thrust_ = Vec3::Zero();
  Vec3 resistance_ = Vec3::Zero();   ///< acceleration by air
  Vec3 disturbance_ = Vec3::Zero();  ///< steady acceleration that the controller compensates
};

}  // namespace voxnav_simulation
