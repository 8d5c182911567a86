// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/GridUpdate.h"
#include "voxnav/base/time.hpp"
#include "voxnav/containers/moving_thing.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/occupancy/new_hit.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

/// The fields of a GridUpdate message besides its blocks.
struct GridUpdateHeader {
  std::string frame_id;
  voxnav::base::StampNs stamp_ns = 0;
  std::uint32_t sequence = 0;
  double resolution_m = 0.0;
};

msg::GridUpdate to_msg(voxnav::containers::GridUpdate update, const GridUpdateHeader& header);

/// Adds what the newest sweep showed beside the map to an update of the local map.
void add_sightings(const std::vector<voxnav::occupancy::NewHit>& hits,
                   const std::vector<voxnav::containers::MovingThing>& things, msg::GridUpdate* msg);

/// Returns the update of a message without checking it: containers::apply() checks lengths and states.
voxnav::containers::GridUpdate from_msg(const msg::GridUpdate& msg);

}  // namespace voxnav_ros
