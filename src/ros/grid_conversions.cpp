// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/grid_conversions.hpp"

#include <utility>

#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

msg::GridUpdate to_msg(voxnav::containers::GridUpdate update, const GridUpdateHeader& header) {
  msg::GridUpdate msg;
  msg.header.frame_id = header.frame_id;
  msg.header.stamp = to_ros(header.stamp_ns);
  msg.sequence = header.sequence;
  msg.is_snapshot = update.is_snapshot;
  msg.resolution_m = header.resolution_m;
  msg.block_indices = std::move(update.block_indices);
  msg.states = std::move(update.states);
  msg.removed_block_indices = std::move(update.removed_block_indices);
  return msg;
}

voxnav::containers::GridUpdate from_msg(const msg::GridUpdate& msg) {
  voxnav::containers::GridUpdate update;
  update.is_snapshot = msg.is_snapshot;
  update.block_indices = msg.block_indices;
  update.states = msg.states;
  update.removed_block_indices = msg.removed_block_indices;
  return update;
}

}  // namespace voxnav_ros
