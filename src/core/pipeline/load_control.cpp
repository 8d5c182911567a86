// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/load_control.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::pipeline {

LoadControl::LoadControl(const LoadControlConfig& config) : config_(base::checked(config)) {}

void LoadControl::add(double work_s, double period_s) {
  if (!std::isfinite(work_s) || !(work_s >= 0.0) || !std::isfinite(period_s) || !(period_s > 0.0)) return;
  const double busy = work_s / period_s;
  if (busy > config_.max_busy_share) {
    decimation_ = std::min(2 * decimation_, config_.max_decimation);
    num_calm_ = 0;
  } else if (busy < 0.4 * config_.max_busy_share) {  // twice the points must fit
    if (++num_calm_ < config_.calm_scans) return;
    decimation_ = std::max(decimation_ / 2, 1);
    num_calm_ = 0;
  } else {
    num_calm_ = 0;
  }
}

}  // namespace voxnav::pipeline
