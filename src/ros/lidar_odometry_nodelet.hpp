// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <nav_msgs/Odometry.h>
#include <sensor_msgs/Imu.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Empty.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_broadcaster.h>
#include <tf2_ros/transform_listener.h>

#include <deque>
#include <optional>

#include "lidar_odometry_config.hpp"
#include "voxnav/OdometryQuality.h"
#include "voxnav/odometry/imu_gate.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"
#include "voxnav_ros/nodelet_base.hpp"

namespace voxnav_ros {

/// The nodelet that takes filtered clouds and IMU samples and publishes odometry of the body. All callbacks run in the
/// nodelet's single-threaded queue, so no mutex is needed.
class LidarOdometryNodelet : public NodeletBase {
 public:
  LidarOdometryNodelet() : NodeletBase("LidarOdometry") {}

 private:
  void initialize() override;
  void start() override;
  void on_imu(const sensor_msgs::ImuConstPtr& msg);
  void on_points(const sensor_msgs::PointCloud2ConstPtr& msg);
  void on_wait(const ros::SteadyTimerEvent&);
  bool on_reset(std_srvs::Trigger::Request&, std_srvs::Trigger::Response& response);
  bool on_reset_odom(std_srvs::Empty::Request&, std_srvs::Empty::Response&);

  /// Returns the pose of a sensor on the body, or nothing (with a warning in the diagnostics) while tf does not know
  /// it.
  std::optional<voxnav::geometry::Pose> mounting(const std::string& frame_id);
  bool make_estimator(const std::string& lidar_frame);
  void take_unmounted();
  void add_imu(const sensor_msgs::Imu& msg);
  void process_ready();
  bool awaits_level(voxnav::base::StampNs stamp_ns);
  void process(const voxnav::cloud::Sweep& sweep);
  void publish(const voxnav::odometry::OdometryResult& result);
  void report(const voxnav::odometry::OdometryResult& result);
  void drop(const ros::Time& stamp, const std::string& reason);
  void complain(const std::string& text);

  voxnav::odometry::LidarOdometryConfig odometry_config_;
  LidarOdometryNodeConfig config_;
  std::unique_ptr<voxnav::odometry::LidarOdometry> estimator_;  // null until the mount of the LiDAR is known
  std::string lidar_frame_;
  std::optional<Eigen::Matrix3d> R_B_I_;
  std::deque<sensor_msgs::ImuConstPtr> unmounted_imu_;  // came before the mounting of the IMU was known
  std::deque<voxnav::odometry::ImuSample> early_imu_;   // came before that of the LiDAR
  std::unique_ptr<voxnav::odometry::ImuGate> gate_;
  std::optional<voxnav::base::StampNs> first_stamp_ns_;  // since the start or the last reset
  bool has_published_ = false;
  std::string points_topic_, imu_topic_;

  std::unique_ptr<tf2_ros::Buffer> tf_buffer_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;
  tf2_ros::TransformBroadcaster tf_broadcaster_;
  ros::Publisher odom_, quality_;
  ros::ServiceServer reset_, reset_odom_;
  ros::SteadyTimer wait_timer_;
  ros::Subscriber imu_, points_;
};

}  // namespace voxnav_ros
