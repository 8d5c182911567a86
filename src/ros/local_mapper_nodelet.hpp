// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/String.h>
#include <mrs_msgs/UavState.h>
#include <nav_msgs/Odometry.h>
#include <std_srvs/Trigger.h>

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "local_mapper_config.hpp"
#include "mapper_sensor.hpp"
#include "tf_locator.hpp"
#include "voxnav/GetGrid.h"
#include "voxnav/OdometryOrigin.h"
#include "voxnav/OdometryQuality.h"
#include "voxnav/OtherUavs.h"
#include "voxnav/pipeline/mapper.hpp"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"

namespace voxnav_ros {

namespace occupancy = voxnav::occupancy;
namespace pipeline = voxnav::pipeline;

/// The nodelet that takes filtered clouds and publishes the local map. All callbacks run in the nodelet's
/// single-threaded queue, so no mutex is needed.
class LocalMapperNodelet : public NodeletBase {
 public:
  LocalMapperNodelet() : NodeletBase("LocalMapper") {}
  ~LocalMapperNodelet() override;

 private:
  void initialize() override;
  void advertise();
  void start() override;

  void on_points(std::size_t sensor, const sensor_msgs::PointCloud2ConstPtr& msg);
  void on_odometry(const nav_msgs::OdometryConstPtr& msg);
  void on_quality(const msg::OdometryQualityConstPtr& msg);
  void on_others(const msg::OtherUavsConstPtr& others);
  void on_uav_state(const mrs_msgs::UavStateConstPtr& msg);
  void follow_estimator(const std::string& frame, const ros::Time& stamp);
  void announce_origin(const ros::Time& stamp, const std::string& previous,
                       const std::optional<voxnav::geometry::Pose>& T_O_previous);
  void find_mount(std::size_t sensor, const std::string& sensor_frame);
  void process();
  void map_next();
  void leave_out(const pipeline::MapperStep& step);

  bool is_snapshot_due(const ros::Time& stamp);
  void publish_map(const pipeline::MapperStep& step);
  msg::GridUpdate update_msg(voxnav::containers::GridUpdate update, const ros::Time& stamp) const;
  void publish_pictures(const ros::Time& stamp);
  void publish_octomap(const ros::Publisher& publisher, bool is_binary, const ros::Time& stamp);
  void hand_over(const std::vector<pipeline::Handover>& handovers);
  std_msgs::Header header(const ros::Time& stamp) const;
  GridUpdateHeader update_header(const ros::Time& stamp) const;

  void restart(const std::string& reason, const std::string& text);
  void report_clear(const std::string& text);
  void watch_load(double work_s, const pipeline::MapperStep& step);
  void watch_silence();
  void drop(MapperSensor* sensor, const ros::Time& stamp, const std::string& reason);
  void warn(const std::string& text);
  void warn_of_missing_beams(const MapperSensor& sensor, const pipeline::SensorConfig& limits,
                             const sensor_msgs::PointCloud2& msg);
  void report(const occupancy::InsertStatistics& s);
  void report(const MapperSensor& sensor);

  bool on_get_map(voxnav::GetGrid::Request& request, voxnav::GetGrid::Response& response);
  bool on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool on_close_submap(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  LocalMapperConfig config_;
  bool uses_odometry_ = false;      // whether poses come from odometry messages instead of tf
  bool follows_estimator_ = false;  // whether the origin of the map is that of the active estimator
  std::string frame_;               // frame O of the map; empty while it is not known
  ros::Time switched_;  // when uav_state was first in a frame whose relation to frame_ is looked for; zero: never
  std::unique_ptr<TfLocator> tf_;
  pipeline::PoseLocator poses_;  // poses of ~odometry_in
  std::unique_ptr<pipeline::Mapper> mapper_;
  std::vector<MapperSensor> sensors_;
  std::vector<pipeline::SensorConfig> limits_;  // of each sensor
  std::optional<std::uint32_t> estimator_iteration_;
  std::uint32_t sequence_ = 0;
  std::uint64_t num_not_finite_ = 0, num_too_near_ = 0, num_far_ = 0, num_clears_ = 0, num_late_ = 0;
  std::uint64_t num_poses_refused_ = 0;
  double work_s_ = 0.0;  // on the scans since the last one that led
  ros::SteadyTime warned_;
  ros::Time map_stamp_, last_inserted_, last_snapshot_, last_occupied_, last_octomap_;
  ros::Publisher origin_, updates_, handovers_, moving_, occupied_, octomap_, octomap_binary_;
  std::vector<ros::ServiceServer> services_;
  ros::Subscriber odometry_, quality_, uav_state_, others_;
  std::size_t num_others_refused_ = 0;
  ros::SteadyTimer overdue_;
};

}  // namespace voxnav_ros
