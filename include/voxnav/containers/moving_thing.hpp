// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/base/time.hpp"
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

/// Another UAV, as it announced where it will be.
struct OtherUav {
  std::string name;
  base::StampNs stamp_ns = 0;          ///< time of the first place
  double step_s = 0.2;                 ///< time between places, positive
  std::vector<geometry::Vec3> places;  ///< at least one, frame O
  /// It is inside a ball of this radius around its place: its body, and the errors of both vehicles' positions.
  double radius_m = 1.0;
  double growth_mps = 0.0;       ///< the ball grows by this from the first place on
  double late_growth_mps = 0.0;  ///< and by this in addition after the last one
  double max_growth_m = 0.0;     ///< but by no more than this
  double horizon_s = 0.0;        ///< it is kept clear of for this time after `seen_ns`
  base::StampNs seen_ns = 0;     ///< the present time of whoever made this
};

}  // namespace voxnav::containers
