// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace voxnav::odometry {

/// Two scans that lie farther apart in time say nothing about the velocity.
constexpr double kMaxScanGap_s = 1.0;

}  // namespace voxnav::odometry
