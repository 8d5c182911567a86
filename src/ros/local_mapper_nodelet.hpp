// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/String.h>
#include <mrs_msgs/UavState.h>
#include <std_srvs/Trigger.h>

#include <deque>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "local_mapper_config.hpp"
#include "pending_scans.hpp"
#include "voxnav/GetGrid.h"
#include "voxnav/OdometryQuality.h"
#include "voxnav/base/clock_watch.hpp"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/pipeline/load_control.hpp"
#include "voxnav/pipeline/submap_scheduler.hpp"
#include "voxnav_ros/cloud_conversions.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/nodelet_base.hpp"

namespace voxnav_ros {

namespace occupancy = voxnav::occupancy;
namespace pipeline = voxnav::pipeline;

/// Filtered clouds in, local map out. All callbacks run in the nodelet's single-threaded queue, so no mutex is needed.
class LocalMapperNodelet : public NodeletBase {
 public:
  LocalMapperNodelet() : NodeletBase("LocalMapper") {}
  ~LocalMapperNodelet() override;

 private:
  void initialize() override;
  void advertise();
  void start() override;

  void on_points(const sensor_msgs::PointCloud2ConstPtr& msg);
  void on_open_beams(const sensor_msgs::PointCloud2ConstPtr& msg);
  void on_quality(const voxnav::OdometryQualityConstPtr& msg);
  void on_uav_state(const mrs_msgs::UavStateConstPtr& msg);
  bool is_waiting_for_open_beams() const;
  std::vector<float> open_beams_at(const ros::Time& stamp) const;
  void process();
  void insert(LocatedScan* scan);
  void thin_out(ScanPoints* points);

  bool is_snapshot_due(const ros::Time& stamp);
  void publish_map(const ros::Time& stamp);
  void publish_pictures(const ros::Time& stamp);
  void hand_over(const std::vector<pipeline::Handover>& handovers);
  std_msgs::Header header(const ros::Time& stamp) const;
  GridUpdateHeader update_header(const ros::Time& stamp) const;

  void restart(const std::string& reason, const std::string& text);
  /// False when the scan is to be left out because of its stamp.
  bool watch_clock(const ros::Time& stamp);
  void watch_jump(const voxnav::geometry::Pose& T_O_B);
  void watch_load(double work_s, const ros::Time& stamp);
  void drop(const ros::Time& stamp, const std::string& reason);
  void warn(const std::string& text);
  void report(const occupancy::InsertStatistics& s);

  bool on_get_map(voxnav::GetGrid::Request& request, voxnav::GetGrid::Response& response);
  bool on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool on_close_submap(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);

  LocalMapperConfig config_;
  std::unique_ptr<occupancy::LocalMap> map_;
  std::unique_ptr<pipeline::SubmapScheduler> scheduler_;
  std::unique_ptr<pipeline::LoadControl> load_;
  std::unique_ptr<PendingScans> scans_;
  voxnav::base::ClockWatch clock_ = voxnav::base::ClockWatch({});
  std::optional<voxnav::geometry::Vec3> last_body_;
  std::optional<std::uint32_t> estimator_iteration_;
  std::uint32_t sequence_ = 0;
  std::uint64_t num_not_finite_ = 0, num_too_near_ = 0, num_far_ = 0, num_clears_ = 0, num_late_ = 0;
  ros::SteadyTime warned_;
  ros::Time last_inserted_, last_snapshot_, last_occupied_, last_octomap_;
  ros::Publisher updates_, handovers_, occupied_, octomap_;
  std::vector<ros::ServiceServer> services_;
  ros::Subscriber points_, open_beams_, quality_, uav_state_;
  std::deque<sensor_msgs::PointCloud2ConstPtr> open_beams_of_;
  ros::SteadyTimer retry_;
};

}  // namespace voxnav_ros
