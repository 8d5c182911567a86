// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "voxnav/occupancy/local_map_config.hpp"
#include "voxnav/occupancy/moving_things.hpp"
#include "voxnav/odometry/lidar_odometry_config.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"

namespace voxnav::pipeline {

/// How scans are thinned out when there is too little time for all of their points.
struct LoadControlConfig {
  double max_busy_share = 0.8;
  int max_decimation = 2;
  int calm_scans = 20;

  template <class V>
  static void fields(V&& v) {
    using C = LoadControlConfig;
    v("max_busy_share", &C::max_busy_share, base::in(0.05, 10.0), "",
      "work per scan over the time between scans beyond which scans are thinned out");
    v("max_decimation", &C::max_decimation, base::in(1, 64), "", "thinnest: every n-th point; 1 = never thin out");
    v("calm_scans", &C::calm_scans, base::in(1, 1000), "",
      "scans with time to spare after which fewer points are left out");
  }
};

/// What the mapper has to know of one sensor beside its mount. Limits of the map hold for all sensors.
struct SensorConfig {
  double max_range_m = 1000.0;
  double no_return_range_m = 1000.0;
  double range_noise_m = 0.0;
  double max_rate_hz = 1000.0;

  template <class V>
  static void fields(V&& v) {
    using C = SensorConfig;
    v("max_range_m", &C::max_range_m, base::in(0.1, 1000.0), "m",
      "farther points of this sensor only clear up to here; map/max_range_m limits it as well");
    v("no_return_range_m", &C::no_return_range_m, base::in(0.0, 1000.0), "m",
      "its beams without return clear up to here; map/no_return_range_m limits it as well");
    v("range_noise_m", &C::range_noise_m, base::in(0.0, 10.0), "m",
      "standard deviation of its ranges at max_range_m, if it is no small part of a voxel: surfaces are not cleared by "
      "beams that may have ended at them");
    v("max_rate_hz", &C::max_rate_hz, base::in(0.1, 1000.0), "Hz", "its scans that come faster are left out");
  }
};

/// Parameters of Mapper; the parts of the pipeline have configurations of their own.
struct MapperConfig {
  bool use_deskew = true;
  int max_pending_scans = 5;
  double max_jump_m = 10.0;
  double max_pose_gap_s = 0.3;
  double vehicle_radius_m = 0.8;

  occupancy::LocalMapConfig map;
  occupancy::MovingThingsConfig moving;
  SubmapSchedulerConfig submap;
  LoadControlConfig load;
  /// The sensors, by cloud::Sweep::sensor; at least one. The mapper's own odometry follows the first.
  std::vector<SensorConfig> sensors{SensorConfig{}};
  /// If set, the mapper's own LiDAR odometry estimates the poses; else they are added from elsewhere.
  std::optional<odometry::LidarOdometryConfig> odometry;
  /// Id of the first submap; if not set, the seconds of its first stamp, so that a restarted node continues with new
  /// ids.
  std::optional<std::uint32_t> first_submap_id;

  template <class V>
  static void fields(V&& v) {
    using C = MapperConfig;
    v("use_deskew", &C::use_deskew, base::any(), "", "undo the motion within a sweep where points carry their time");
    v("max_pending_scans", &C::max_pending_scans, base::in(1, 1000), "",
      "scans of each sensor that may wait for their pose");
    v("max_jump_m", &C::max_jump_m, base::in(0.1, 10000.0), "m",
      "a pose that jumps farther between scans clears the map");
    v("max_pose_gap_s", &C::max_pose_gap_s, base::in(0.01, 10.0), "s",
      "poses of odometry messages or of a recording that are farther apart do not tell where the body was between "
      "them");
    v("vehicle_radius_m", &C::vehicle_radius_m, base::in(0.0, 10.0), "m",
      "voxels this near to the body are marked as free unless they are occupied; 0 = off");
  }
  std::vector<std::string> problems() const;
};

}  // namespace voxnav::pipeline
