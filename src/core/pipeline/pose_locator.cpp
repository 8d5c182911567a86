// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/pose_locator.hpp"

namespace voxnav::pipeline {

SweepLocation PoseLocator::locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const {
  SweepLocation out;
  if (!T_B_L_) {
    out.problem = "the sensor's mounting is unknown";
    return out;
  }
  const auto start = poses_.at(sweep.start_ns);
  const auto middle = poses_.at(sweep.start_ns + duration_ns / 2);
  const auto end = poses_.at(sweep.start_ns + duration_ns);
  if (start && middle && end) {
    out.status = SweepLocation::Status::kKnown;
    out.poses = {{*start * *T_B_L_, *end * *T_B_L_, duration_ns}, *middle};
  } else if (poses_.is_before_all(sweep.start_ns)) {
    out.status = SweepLocation::Status::kNever;
    out.problem = "all poses are newer than its start";
  } else {
    out.problem = poses_.empty() ? "there are no poses" : "all poses are older than its end";
  }
  return out;
}

}  // namespace voxnav::pipeline
