// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav_simulation/cloud_encoder.hpp"

namespace voxnav_simulation {

/// Parameters of the lidar_simulator node besides those of the sensor.
struct LidarSimulatorConfig {
  std::string world_yaml;
  int seed = 1;
  DriverLayout layout = DriverLayout::kOuster;
  std::string sensor_frame_id = "uav1/os_sensor";
  std::string body_frame_id = "uav1/fcu";
  int max_marker_triangles = 60000;
  double loss_ratio = 0.0;
  std::vector<std::string> other_uavs{};
  std::vector<std::string> waiting_nodes{};
  std::vector<std::string> acting_nodes{};

  template <class V>
  static void fields(V&& v) {
    using C = LidarSimulatorConfig;
    using voxnav::base::any;
    using voxnav::base::in;
    using voxnav::base::one_of;
    v("world_yaml", &C::world_yaml, any(), "", "file of the world, as worlds/forest.yaml; must be given");
    v("seed", &C::seed, in(0, 2147483647), "", "seed of the world and of the sensor's errors");
    v("layout", &C::layout, one_of<DriverLayout>(), "",
      "ouster: 48 bytes per point with times; gazebo: 29 bytes, whole turn at one instant");
    v("sensor_frame_id", &C::sensor_frame_id, any(), "", "frame of the clouds");
    v("body_frame_id", &C::body_frame_id, any(), "", "parent of the sensor frame");
    v("max_marker_triangles", &C::max_marker_triangles, in(0, 2000000), "",
      "triangles of the world shown in rviz, 0 = none; leaves are thinned out first");
    v("loss_ratio", &C::loss_ratio, in(0, 1), "", "share of clouds that are lost on their way, each for itself");
    v("other_uavs", &C::other_uavs, any(), "",
      "names of other UAVs of simulators of their own in the same world, whose bodies the sensor sees");
    v("waiting_nodes", &C::waiting_nodes, any(), "",
      "nodes that simulated time waits for after each cloud; a lost one is reported in their place");
    v("acting_nodes", &C::acting_nodes, any(), "",
      "nodes that act after each cloud and report it; a lost one is announced to them, so that they act without it");
  }
};

}  // namespace voxnav_simulation
