// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/buffer.h>
#include <tf2_ros/transform_listener.h>

#include <chrono>
#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/cloud/cloud_layout.hpp"
#include "voxnav/pipeline/deskew.hpp"

namespace voxnav_ros {

/// The points of a cloud as the map takes them.
struct ScanPoints {
  std::vector<float> xyz;
  std::vector<std::uint32_t> time_offsets_ns;  ///< all zero when the cloud has no times
  std::uint32_t duration_ns = 0;               ///< largest offset
};
/// @throws std::invalid_argument when the cloud cannot be read
ScanPoints read_points(const sensor_msgs::PointCloud2& msg);

/// A scan whose poses are known.
struct LocatedScan {
  sensor_msgs::PointCloud2ConstPtr msg;
  ScanPoints points;
  voxnav::pipeline::SweepMotion motion;                               ///< duration 0 when the cloud has no times
  voxnav::geometry::Pose T_O_B = voxnav::geometry::Pose::Identity();  ///< halfway through the sweep
};

/// Clouds wait here, in order, until tf can say where the sensor was during the whole sweep. Nothing is ever assumed
/// about a pose: a scan that waits too long is dropped. Waiting does not depend on the simulated clock.
class PendingScans {
 public:
  PendingScans(std::string odometry_frame, std::string body_frame, double timeout_s, int max_scans, bool use_times);

  /// @throws std::invalid_argument when the cloud cannot be read
  /// @return a scan that had to give way, if any
  sensor_msgs::PointCloud2ConstPtr add(const sensor_msgs::PointCloud2ConstPtr& msg);
  struct Next {
    std::optional<LocatedScan> scan;
    sensor_msgs::PointCloud2ConstPtr dropped;
    std::string reason;  ///< why it was dropped
  };
  /// The oldest scan if it is located or overdue; call until both are empty.
  Next next();
  struct Oldest {
    ros::Time stamp;
    double age_s;  ///< wall time since it came
  };
  std::optional<Oldest> oldest() const;
  void clear() { pending_.clear(); }

 private:
  struct Waiting {
    sensor_msgs::PointCloud2ConstPtr msg;
    ScanPoints points;
    std::chrono::steady_clock::time_point since;
  };
  static double waited_s(const Waiting& waiting);
  std::optional<LocatedScan> locate(const Waiting& waiting, std::string* problem) const;
  std::optional<voxnav::geometry::Pose> lookup(const std::string& frame, const ros::Time& stamp,
                                               std::string* problem) const;

  std::string odometry_frame_;
  std::string body_frame_;
  double timeout_s_;
  std::size_t max_scans_;
  bool use_times_;
  tf2_ros::Buffer buffer_;
  std::unique_ptr<tf2_ros::TransformListener> listener_;
  std::deque<Waiting> pending_;
};

}  // namespace voxnav_ros
