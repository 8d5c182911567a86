// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav_simulation/lidar_config.hpp"

namespace voxnav_simulation {

/// The parts of the UAV as its own sensor sees them. They move with the sensor, so that the range of every beam to them
/// is known beforehand.
class OwnBody {
 public:
  explicit OwnBody(const LidarConfig& config);
  /// Range to the first part along a unit direction from the sensor's origin; infinite when there is none.
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
