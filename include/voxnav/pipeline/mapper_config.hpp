// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav/occupancy/local_map_config.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"
#include "voxnav/pipeline/load_control.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"

namespace voxnav::pipeline {

/// Parameters of Mapper; the parts of the pipeline have configurations of their own.
struct MapperConfig {
  bool use_deskew = true;
  int max_pending_scans = 5;
  double max_jump_m = 10.0;
  double vehicle_radius_m = 0.8;

  occupancy::LocalMapConfig map;
  SubmapSchedulerConfig submap;
  LoadControlConfig load;
  /// If set, the mapper's own LiDAR odometry estimates the poses; else they are added from elsewhere.
  std::optional<odometry::LidarOdometryConfig> odometry;
  /// Id of the first submap; if not set, the seconds of its first stamp, so that a restarted node continues with new
  /// ids.
  std::optional<std::uint32_t> first_submap_id;

  template <class V>
  static void fields(V&& v) {
    using C = MapperConfig;
    v("use_deskew", &C::use_deskew, base::any(), "", "undo the motion within a sweep where points carry their time");
    v("max_pending_scans", &C::max_pending_scans, base::in(1, 1000), "", "scans that may wait for their pose");
    v("max_jump_m", &C::max_jump_m, base::in(0.1, 10000.0), "m",
      "a pose that jumps farther between scans clears the map");
    v("vehicle_radius_m", &C::vehicle_radius_m, base::in(0.0, 10.0), "m",
      "voxels this near to the body are marked as free unless they are occupied; 0 = off");
  }
};

}  // namespace voxnav::pipeline
