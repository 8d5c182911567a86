// SPDX-License-Identifier: BSD-3-Clause
#include "moving_markers.hpp"

#include <algorithm>
#include <string>

#include "voxnav_ros/conversions.hpp"

namespace voxnav_ros {
namespace {

using visualization_msgs::Marker;
using voxnav::containers::MovingThing;

/// Things of which little was seen are shown at least this large.
constexpr double kLeastSize_m = 0.2;

Marker marker_of(const MovingThing& thing, const std_msgs::Header& header, const std::string& ns) {
  Marker out;
  out.header = header;
  out.ns = ns;
  out.id = static_cast<int>(thing.id);
  out.action = Marker::ADD;
  out.pose.orientation.w = 1.0;
  out.color.r = 1.0F;
  out.color.g = 0.35F;
  out.color.a = 0.8F;
  return out;
}

Marker body_of(const MovingThing& thing, const std_msgs::Header& header) {
  Marker out = marker_of(thing, header, "moving");
  out.type = Marker::CYLINDER;
  out.pose.position = to_msg(thing.position);
  out.scale.x = out.scale.y = std::max(kLeastSize_m, 2.0 * thing.half_size_m.head<2>().maxCoeff());
  out.scale.z = std::max(kLeastSize_m, 2.0 * thing.half_size_m.z());
  return out;
}

Marker arrow_of(const MovingThing& thing, const std_msgs::Header& header) {
  Marker out = marker_of(thing, header, "velocity");
  out.type = Marker::ARROW;
  out.points = {to_msg(thing.position), to_msg(voxnav::geometry::Vec3(thing.position + thing.velocity))};
  out.scale.x = 0.1;
  out.scale.y = 0.25;
  return out;
}

}  // namespace

visualization_msgs::MarkerArray moving_markers(const std::vector<MovingThing>& things, const std_msgs::Header& header) {
  visualization_msgs::MarkerArray out;
  Marker clear;
  clear.header = header;
  clear.action = Marker::DELETEALL;
  out.markers.push_back(clear);
  for (const MovingThing& thing : things) {
    out.markers.push_back(body_of(thing, header));
    out.markers.push_back(arrow_of(thing, header));
  }
  return out;
}

}  // namespace voxnav_ros
