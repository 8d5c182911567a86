// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::containers {

/// Something that moves, as it is at the stamp of the newest sweep; frame of the map.
struct MovingThing {
  std::uint32_t id = 0;                              ///< the same as long as it is followed
  geometry::Vec3 position = geometry::Vec3::Zero();  ///< middle of its box
  geometry::Vec3 velocity = geometry::Vec3::Zero();
  geometry::Vec3 half_size_m = geometry::Vec3::Zero();  ///< of the box around all that was seen of it
  double position_sigma_m = 0.0;                        ///< standard deviation of each coordinate
  double velocity_sigma_mps = 0.0;
};

}  // namespace voxnav::containers
