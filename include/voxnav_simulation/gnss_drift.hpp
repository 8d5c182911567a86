// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/kinematic_state.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

struct GnssDriftConfig {
  double bound_m = 2.0;
  double walk_m = 0.1;
  double smoothing_s = 4.0;
  double heading_bound_rad = 0.0;
  double heading_walk_rad = 0.002;

  template <class V>
  static void fields(V&& v) {
    using C = GnssDriftConfig;
    using voxnav::base::in;
    v("bound_m", &C::bound_m, in(0, 100), "m", "largest distance between estimated and true position; 0: no drift");
    v("walk_m", &C::walk_m, in(0, 10), "m/sqrt(s)", "random walk of the position's bias, per axis");
    v("smoothing_s", &C::smoothing_s, in(0.5, 100), "s", "time constant with which the estimate follows its bias");
    v("heading_bound_rad", &C::heading_bound_rad, in(0, 1), "rad", "largest error of the estimated heading; 0: none");
    v("heading_walk_rad", &C::heading_walk_rad, in(0, 1), "rad/sqrt(s)", "random walk of the heading's error");
  }
};

/// The error of the estimated pose: a random walk that is kept inside a ball and smoothed by three first-order low-pass
/// filters in series, so that the estimate has a continuous velocity and acceleration. The error starts at zero and
/// never leaves the ball, because a first-order filter only averages its inputs.
class GnssDrift {
 public:
  GnssDrift(const GnssDriftConfig& config, std::uint64_t seed);

  void step(double dt_s);
  /// The estimated minus the true position in metres, and its derivatives with respect to time.
  Vec3 position() const { return lags_[2].head<3>(); }
  Vec3 velocity() const { return velocity_.head<3>(); }
  Vec3 acceleration() const { return acceleration_.head<3>(); }
  double heading_rad() const { return lags_[2][3]; }

 private:
  GnssDriftConfig config_;
  Rng random_;
  Eigen::Vector4d walk_ = Eigen::Vector4d::Zero();  ///< metres x, y, z and radians of heading
  Eigen::Vector4d lags_[3];
  Eigen::Vector4d velocity_ = Eigen::Vector4d::Zero();
  Eigen::Vector4d acceleration_ = Eigen::Vector4d::Zero();
};

}  // namespace voxnav_simulation
