// SPDX-License-Identifier: BSD-3-Clause
#include "geometry/pose_buffer.hpp"
#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::pipeline {
namespace {

/// How far the poses around the beginning, the middle or the end of a sweep are apart, where that is too far.
std::optional<base::StampNs> gap_in(const geometry::PoseBuffer& poses, base::StampNs start_ns,
                                    std::uint32_t duration_ns) {
  for (const std::uint32_t after_ns : {std::uint32_t{0}, duration_ns / 2, duration_ns}) {
    if (const auto gap_ns = poses.gap_around(start_ns + after_ns)) return gap_ns;
  }
  return std::nullopt;
}

}  // namespace

PoseLocator::PoseLocator() : poses_(std::make_unique<geometry::PoseBuffer>()) {}
PoseLocator::~PoseLocator() = default;
PoseLocator::PoseLocator(PoseLocator&&) noexcept = default;
PoseLocator& PoseLocator::operator=(PoseLocator&&) noexcept = default;

void PoseLocator::set_mount(const geometry::Pose& T_B_L, std::size_t sensor) { mounts_[sensor] = T_B_L; }

void PoseLocator::set_max_gap(std::optional<base::StampNs> max_gap_ns) { poses_->set_max_gap_ns(max_gap_ns); }

bool PoseLocator::add(base::StampNs stamp_ns, const geometry::Pose& T_O_B) { return poses_->add(stamp_ns, T_O_B); }

void PoseLocator::move_frame(const geometry::Pose& T_new_O) { poses_->move_frame(T_new_O); }

SweepLocation PoseLocator::locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const {
  SweepLocation out;
  const auto mount = mounts_.find(sweep.sensor);
  if (mount == mounts_.end()) {
    out.problem = "the sensor's mounting is unknown";
    return out;
  }
  const auto start = poses_->at(sweep.start_ns);
  const auto middle = poses_->at(sweep.start_ns + duration_ns / 2);
  const auto end = poses_->at(sweep.start_ns + duration_ns);
  if (start && middle && end) {
    out.status = SweepLocation::Status::kKnown;
    out.poses = {{*start * mount->second, *end * mount->second, duration_ns}, *middle};
  } else if (poses_->is_before_all(sweep.start_ns)) {
    out.status = SweepLocation::Status::kNever;
    out.problem = "all poses are newer than its start";
  } else if (const auto gap_ns = gap_in(*poses_, sweep.start_ns, duration_ns)) {
    out.status = SweepLocation::Status::kNever;
    out.problem = "the poses around it are " + std::to_string(base::to_seconds(*gap_ns)) + " s apart";
  } else {
    out.problem = poses_->empty() ? "there are no poses" : "all poses are older than its end";
  }
  return out;
}

}  // namespace voxnav::pipeline
