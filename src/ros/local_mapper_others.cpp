// SPDX-License-Identifier: BSD-3-Clause
// Other UAVs, whose bodies the local mapper does not map.
#include "local_mapper_nodelet.hpp"
#include "voxnav/containers/moving_thing.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/messages.hpp"

namespace voxnav_ros {

void LocalMapperNodelet::on_others(const msg::OtherUavsConstPtr& others) {
  if (frame_name(others->header.frame_id) != frame_) {
    diagnostics().set_counter("others_refused", static_cast<double>(++num_others_refused_));
    return warn("other UAVs are told in '" + others->header.frame_id + "', the map is in '" + frame_ +
                "': their bodies are mapped");
  }
  std::vector<voxnav::containers::OtherUav> known;
  for (const msg::OtherUav& other : others->others) {
    known.emplace_back();
    known.back().name = other.name;
    known.back().stamp_ns = to_ns(other.stamp);
    known.back().seen_ns = to_ns(others->header.stamp);
    known.back().step_s = other.step_s;
    known.back().radius_m = other.body_radius_m;
    for (const geometry_msgs::Point& place : other.places) known.back().places.push_back(from_msg(place));
  }
  try {
    mapper_->set_others(std::move(known));
  } catch (const std::invalid_argument& error) {
    diagnostics().set_counter("others_refused", static_cast<double>(++num_others_refused_));
    warn(error.what());
  }
}

}  // namespace voxnav_ros
