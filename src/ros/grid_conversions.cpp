// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_ros/grid_conversions.hpp"

#include <geometry_msgs/Vector3.h>

#include <utility>

#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {
namespace {

geometry_msgs::Vector3 vector_of(const voxnav::geometry::Vec3& vector) {
  geometry_msgs::Vector3 out;
  out.x = vector.x();
  out.y = vector.y();
  out.z = vector.z();
  return out;
}

}  // namespace

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

void add_sightings(const std::vector<voxnav::occupancy::NewHit>& hits,
                   const std::vector<voxnav::containers::MovingThing>& things, msg::GridUpdate* msg) {
  for (const voxnav::occupancy::NewHit& hit : hits) {
    if (hit.state != voxnav::containers::VoxelState::kFree) continue;  // the map tells of it already
    msg->new_hits.insert(msg->new_hits.end(), {hit.voxel.x, hit.voxel.y, hit.voxel.z});
    msg->new_hit_returns.push_back(hit.num_points);
  }
  for (const voxnav::containers::MovingThing& thing : things) {
    msg::MovingThing out;
    out.id = thing.id;
    out.position = to_msg(thing.position);
    out.velocity = vector_of(thing.velocity);
    out.half_size_m = vector_of(thing.half_size_m);
    out.position_sigma_m = thing.position_sigma_m;
    out.velocity_sigma_mps = thing.velocity_sigma_mps;
    msg->moving_things.push_back(out);
  }
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
