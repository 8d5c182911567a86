// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/base/config.hpp"
#include "voxnav/cloud/depth_cloud.hpp"

namespace voxnav_simulation {

/// Parameters of the depth_camera_simulator node besides those of the camera.
struct DepthCameraSimulatorConfig {
  std::string world_yaml;
  int seed = 1;
  voxnav::cloud::DepthEncoding encoding = voxnav::cloud::DepthEncoding::kMillimetres;
  std::string camera_frame_id = "uav1/depth_optical";
  std::string body_frame_id = "uav1/fcu";

  template <class V>
  static void fields(V&& v) {
    using C = DepthCameraSimulatorConfig;
    using voxnav::base::any;
    v("world_yaml", &C::world_yaml, any(), "", "file of the world, as worlds/forest.yaml; must be given");
    v("seed", &C::seed, voxnav::base::in(0, 2147483647), "", "seed of the world and of the camera's errors");
    v("encoding", &C::encoding, voxnav::base::one_of<voxnav::cloud::DepthEncoding>(), "",
      "16UC1 and mono16: millimetres; 32FC1: metres");
    v("camera_frame_id", &C::camera_frame_id, any(), "", "optical frame of the images");
    v("body_frame_id", &C::body_frame_id, any(), "", "parent of the optical frame");
  }
};

}  // namespace voxnav_simulation
