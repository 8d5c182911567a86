// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::cloud {

/// Positions and times of a cloud, all points in their order, whatever their values.
struct TimedPoints {
  std::vector<geometry::Vec3f> positions;  ///< m, sensor frame
  std::vector<float> times_s;              ///< after the start of the sweep; empty when the cloud has no times
  base::StampNs sweep_start_ns = 0;        ///< the cloud's stamp, or earlier when its times are negative
};

TimedPoints timed_points(const RawCloudView& cloud);

}  // namespace voxnav::cloud
