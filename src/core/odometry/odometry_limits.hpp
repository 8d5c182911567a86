// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace voxnav::odometry {

/// Scans farther apart tell nothing about the velocity.
constexpr double kMaxScanGap_s = 1.0;

}  // namespace voxnav::odometry
