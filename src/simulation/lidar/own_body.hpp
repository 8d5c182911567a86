// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav_simulation/lidar_config.hpp"

namespace voxnav_simulation {

/// The parts of the UAV that its own sensor sees. They move with the sensor, so that the range of every beam to them
/// can be computed once.
class OwnBody {
 public:
  explicit OwnBody(const LidarConfig& config);
  /// Returns the range to the first part along a unit direction from the sensor's origin; infinite if there is none.
  double range_m(const Vec3& direction_L) const;

 private:
  struct Capsule {
    Vec3 a;
    Vec3 b;
    double radius_m;
  };
  std::vector<Capsule> capsules_L_;
};

}  // namespace voxnav_simulation
