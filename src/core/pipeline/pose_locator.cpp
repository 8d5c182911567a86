// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/pose_buffer.hpp"
#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::pipeline {

PoseLocator::PoseLocator() : poses_(std::make_unique<geometry::PoseBuffer>()) {}
PoseLocator::~PoseLocator() = default;
PoseLocator::PoseLocator(PoseLocator&&) noexcept = default;
PoseLocator& PoseLocator::operator=(PoseLocator&&) noexcept = default;

bool PoseLocator::add(base::StampNs stamp_ns, const geometry::Pose& T_O_B) { return poses_->add(stamp_ns, T_O_B); }

SweepLocation PoseLocator::locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const {
  SweepLocation out;
  if (!T_B_L_) {
    out.problem = "the sensor's mounting is unknown";
    return out;
  }
  const auto start = poses_->at(sweep.start_ns);
  const auto middle = poses_->at(sweep.start_ns + duration_ns / 2);
  const auto end = poses_->at(sweep.start_ns + duration_ns);
  if (start && middle && end) {
    out.status = SweepLocation::Status::kKnown;
    out.poses = {{*start * *T_B_L_, *end * *T_B_L_, duration_ns}, *middle};
  } else if (poses_->is_before_all(sweep.start_ns)) {
    out.status = SweepLocation::Status::kNever;
    out.problem = "all poses are newer than its start";
  } else {
    out.problem = poses_->empty() ? "there are no poses" : "all poses are older than its end";
  }
  return out;
}

}  // namespace voxnav::pipeline
