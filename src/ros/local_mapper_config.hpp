// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cctype>
#include <set>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav_ros {

/// The source of the local mapper's poses.
enum class MapperPoses { kTf, kOdometry };
constexpr auto words_of(MapperPoses) { return std::array{"tf", "odometry"}; }

/// Parameters of the LocalMapper nodelet beside those of its map and its scheduler.
struct LocalMapperConfig {
  std::string odometry_frame = "world_origin";
  std::string body_frame = "fcu";
  MapperPoses pose_source = MapperPoses::kTf;
  std::vector<std::string> sensors{"lidar"};
  std::vector<std::string> idle_sensors;
  double tf_timeout_s = 0.5;
  double snapshot_period_s = 0.0;
  double occupied_period_s = 10.0;
  double octomap_period_s = 1.0;

  template <class V>
  static void fields(V&& v) {
    using C = LocalMapperConfig;
    using voxnav::base::any;
    using voxnav::base::in;
    v("odometry_frame", &C::odometry_frame, any(), "",
      "frame O of the map: continuous, may drift; empty: that of ~uav_state_in, also after a switch of the estimator");
    v("body_frame", &C::body_frame, any(), "", "frame B of the UAV");
    v("pose_source", &C::pose_source, voxnav::base::one_of<MapperPoses>(), "",
      "tf: poses of the sensor by tf; odometry: of the body from ~odometry_in, by tf only where the sensor sits on it");
    v("sensors", &C::sensors, any(), "",
      "names of the sensors: the filtered clouds of the first come on ~points_in, those of another on "
      "~NAME/points_in; each may have a section of its name, like lidar");
    v("idle_sensors", &C::idle_sensors, any(), "",
      "names of sensors that are launched, and may have sections here, but whose clouds are not mapped");
    v("tf_timeout_s", &C::tf_timeout_s, in(0.01, 10.0), "s",
      "time that a scan waits for its pose before it is dropped");
    v("snapshot_period_s", &C::snapshot_period_s, in(0.0, 1000.0), "s",
      "period of whole maps on ~map_out; 0 = only the first one: a reader that missed a change calls ~get_map_in");
    v("occupied_period_s", &C::occupied_period_s, in(0.1, 1000.0), "s",
      "period of the cloud of occupied voxels on ~occupied_out");
    v("octomap_period_s", &C::octomap_period_s, in(0.05, 1000.0), "s",
      "period of OctoMaps on ~octomap_out (probabilities) and ~octomap_binary_out (occupied or free), each sent while "
      "somebody subscribes; less than the period of scans sends one for each scan");
  }
  std::vector<std::string> problems() const;
};

/// Names of sensors are those of sections, beside the ones that the node has anyway.
inline std::vector<std::string> LocalMapperConfig::problems() const {
  const std::set<std::string> taken{"map", "submap", "mapper", "load", "node", "time"};
  std::vector<std::string> out;
  if (odometry_frame.empty() && pose_source == MapperPoses::kOdometry) {
    out.emplace_back("odometry_frame must be named where pose_source is odometry");
  }
  if (sensors.empty()) out.emplace_back("sensors must hold at least one name");
  std::set<std::string> known;
  std::vector<std::string> names = sensors;
  names.insert(names.end(), idle_sensors.begin(), idle_sensors.end());
  for (const std::string& name : names) {
    const auto is_part = [](unsigned char c) { return std::isalnum(c) != 0 || c == '_'; };
    const bool is_name = !name.empty() && std::isalpha(static_cast<unsigned char>(name.front())) != 0 &&
                         std::all_of(name.begin(), name.end(), is_part);
    if (!is_name) out.push_back("sensors: '" + name + "' is no name of letters, digits and underscores");
    if (taken.count(name) != 0) out.push_back("sensors: '" + name + "' is another section of this node");
    if (!known.insert(name).second) out.push_back("sensors: '" + name + "' is there twice");
  }
  return out;
}

}  // namespace voxnav_ros
