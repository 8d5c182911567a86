// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "geometry/pose_buffer.hpp"
#include "voxnav/pipeline/sweep_locator.hpp"

namespace voxnav::pipeline {

/// Locates the sweeps of one sensor by stamped poses of the body on which it is mounted.
class PoseLocator final : public SweepLocator {
 public:
  void set_mount(const geometry::Pose& T_B_L) { T_B_L_ = T_B_L; }
  bool add(base::StampNs stamp_ns, const geometry::Pose& T_O_B) { return poses_.add(stamp_ns, T_O_B); }
  SweepLocation locate(const cloud::Sweep& sweep, std::uint32_t duration_ns) const override;

 private:
  geometry::PoseBuffer poses_;
  std::optional<geometry::Pose> T_B_L_;
};

}  // namespace voxnav::pipeline
