// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/GridUpdate.h"
#include "voxnav/base/time.hpp"
#include "voxnav/containers/state_grid.hpp"
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

/// Returns the update of a message without checking it: containers::apply() checks lengths and states.
voxnav::containers::GridUpdate from_msg(const msg::GridUpdate& msg);

}  // namespace voxnav_ros
