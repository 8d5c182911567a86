// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/config.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

constexpr double kGravity = 9.81;

struct ImuConfig {
  double gyro_noise = 0.0005;
  double accel_noise = 0.005;
  double gyro_bias = 0.005;
  double accel_bias = 0.05;
  double gyro_bias_walk = 1e-5;
  double accel_bias_walk = 1e-4;

  template <class V>
  static void fields(V&& v) {
    using C = ImuConfig;
    using voxnav::base::in;
    v("gyro_noise", &C::gyro_noise, in(0, 1), "rad/s/sqrt(Hz)", "white noise of angular velocity");
    v("accel_noise", &C::accel_noise, in(0, 10), "m/s^2/sqrt(Hz)", "white noise of acceleration");
    v("gyro_bias", &C::gyro_bias, in(0, 1), "rad/s", "standard deviation of the constant bias, per axis");
    v("accel_bias", &C::accel_bias, in(0, 5), "m/s^2", "standard deviation of the constant bias, per axis");
    v("gyro_bias_walk", &C::gyro_bias_walk, in(0, 1), "rad/s/sqrt(s)", "random walk of the bias");
    v("accel_bias_walk", &C::accel_bias_walk, in(0, 1), "m/s^2/sqrt(s)", "random walk of the bias");
  }
};

/// One inertial measurement in the body frame. It is the average over the step that ends at the stamp, because
/// strapdown units integrate between two outputs.
struct ImuReading {
  voxnav::base::StampNs stamp_ns = 0;
  Vec3 gyro = Vec3::Zero();   ///< rad/s
  Vec3 accel = Vec3::Zero();  ///< specific force, m/s^2; (0, 0, 9.81) at rest
};

/// Adds bias and noise to true angular velocity and specific force.
class ImuModel {
 public:
  ImuModel(const ImuConfig& config, std::uint64_t seed);
  void corrupt(double dt_s, ImuReading* sample);

 private:
  Vec3 normal(double sigma);

  ImuConfig config_;
  Rng random_;
  Vec3 gyro_bias_;
  Vec3 accel_bias_;
};

}  // namespace voxnav_simulation
