// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"

namespace voxnav::bindings {

/// The source of the poses of a recording's scans.
enum class PoseSource { kAuto, kRecording, kLidar };
constexpr auto words_of(PoseSource) { return std::array{"auto", "recording", "lidar"}; }

/// Where the mount of a recording's LiDAR is from.
enum class MountSource {
  kAuto,       ///< as given, unless all zero; else from the recording
  kRecording,  ///< from its transforms
  kGiven,      ///< mount_position_m and mount_rpy_rad, whatever they are
};
constexpr auto words_of(MountSource) { return std::array{"auto", "recording", "given"}; }

/// Parameters of the offline runner (scripts/map_bag) beside those of the parts that it runs.
struct OfflineConfig {
  std::string cloud_topic;
  std::vector<std::string> further_cloud_topics;
  std::vector<std::string> depth_camera_topics;
  std::string odometry_topic;
  std::string odometry_frame;
  std::string imu_topic;
  PoseSource pose_source = PoseSource::kAuto;
  MountSource mount_source = MountSource::kAuto;
  std::array<double, 3> mount_position_m{0.0, 0.0, 0.0};
  std::array<double, 3> mount_rpy_rad{0.0, 0.0, 0.0};
  double safety_distance_m = 1.5;
  bool write_mesh = true;

  template <class V>
  static void fields(V&& v) {
    using C = OfflineConfig;
    v("cloud_topic", &C::cloud_topic, base::any(), "",
      "topic of the clouds in a bag, or NAME=TOPIC; empty = chosen by fields, rate and extent");
    v("further_cloud_topics", &C::further_cloud_topics, base::any(), "",
      "topics of the clouds of other sensors, or NAME=TOPIC, which are mapped as well; where they sit is as the "
      "transforms say");
    v("depth_camera_topics", &C::depth_camera_topics, base::any(), "",
      "topics of the depth images of cameras, or NAME=TOPIC, which are mapped as well; camera_info is beside them");
    v("odometry_topic", &C::odometry_topic, base::any(), "",
      "topic of body poses in a bag; empty = chosen by mount and rate");
    v("odometry_frame", &C::odometry_frame, base::any(), "",
      "frame of the poses that are taken from /tf where no topic has them; empty = chosen by name and motion");
    v("imu_topic", &C::imu_topic, base::any(), "", "topic of the IMU in a bag; empty = chosen by mount and rate");
    v("pose_source", &C::pose_source, base::one_of<PoseSource>(), "",
      "auto takes the recording's poses where it has them, and LiDAR odometry otherwise");
    v("mount_source", &C::mount_source, base::one_of<MountSource>(), "",
      "auto takes the two below unless they are all zero, and else the transforms of the recording; given takes them "
      "as they are");
    v("mount_position_m", &C::mount_position_m, base::in(-10, 10), "m", "position of the LiDAR on the body");
    v("mount_rpy_rad", &C::mount_rpy_rad, base::in(-6.3, 6.3), "rad", "roll, pitch and yaw of the LiDAR on the body");
    v("safety_distance_m", &C::safety_distance_m, base::in(0.1, 10), "m",
      "voxels nearer to a surface than this are obstacles in obstacles.ply");
    v("write_mesh", &C::write_mesh, base::any(), "", "write mesh.ply, which takes most of the closing time");
  }
};

}  // namespace voxnav::bindings
