// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/gnss_drift.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {

GnssDrift::GnssDrift(const GnssDriftConfig& config, std::uint64_t seed)
    : config_(voxnav::base::checked(config)), random_(seed, 0x647269667400) {
  for (auto& lag : lags_) lag.setZero();
}

void GnssDrift::step(double dt_s) {
  const double root = std::sqrt(dt_s);
  for (int i = 0; i < 3; ++i) walk_[i] += config_.walk_m * root * random_.normal();
  walk_[3] += config_.heading_walk_rad * root * random_.normal();
  const double distance = walk_.head<3>().norm();
  if (distance > config_.bound_m) walk_.head<3>() *= config_.bound_m / distance;
  walk_[3] = std::clamp(walk_[3], -config_.heading_bound_rad, config_.heading_bound_rad);

  const double gain = dt_s / config_.smoothing_s;
  const Eigen::Vector4d before = velocity_;
  Eigen::Vector4d in = walk_;
  for (auto& lag : lags_) {
    const Eigen::Vector4d old = lag;
    lag += gain * (in - lag);
    in = old;
  }
  velocity_ = (lags_[1] - lags_[2]) / config_.smoothing_s;
  acceleration_ = (velocity_ - before) / dt_s;
}

}  // namespace voxnav_simulation
