// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/String.h>
#include <sensor_msgs/PointCloud2.h>
#include <tf2_ros/transform_listener.h>

#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "submap_integrator_config.hpp"
#include "submap_integrator_map.hpp"
#include "voxnav/GetGrid.h"
#include "voxnav/GetSubmaps.h"
#include "voxnav/Handover.h"
#include "voxnav/Submap.h"
#include "voxnav/SubmapPoses.h"
#include "voxnav/submap/projective_integrator.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/nodelet_base.hpp"
#include "voxnav_ros/worker.hpp"

namespace voxnav_ros {

/// Handovers (or clouds) in, finished submaps and obstacles out. Callbacks only queue; one worker thread finishes
/// submaps and keeps the merged map, so no sensor waits. One mutex guards everything below it.
class SubmapIntegratorNodelet : public NodeletBase {
 public:
  SubmapIntegratorNodelet() : NodeletBase("SubmapIntegrator") {}

 private:
  void initialize() override;
  void start() override;
  void advertise();
  void enqueue(const char* what, std::function<void()> task);
  void refuse(const std::string& what, const std::string& reason);

  void on_handover(const voxnav::HandoverConstPtr& msg);
  void on_poses(const voxnav::SubmapPosesConstPtr& msg);
  void on_points(const sensor_msgs::PointCloud2ConstPtr& msg);
  void on_snapshot_time(const ros::SteadyTimerEvent&);
  bool on_get_obstacles(voxnav::GetGrid::Request&, voxnav::GetGrid::Response& response);
  bool on_get_submaps(voxnav::GetSubmaps::Request&, voxnav::GetSubmaps::Response& response);
  bool on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);

  // On the worker, with the mutex held.
  void take_handover(const voxnav::Handover& msg);
  void take_poses(const voxnav::SubmapPoses& msg);
  void integrate(const sensor_msgs::PointCloud2& msg);
  void close_projective(submap::SubmapEntry entry);
  void add(submap::SubmapEntry entry);
  void refresh(const ros::Time& stamp, const std::vector<std::uint32_t>& changed_ids);
  void publish_obstacles(voxnav::containers::GridUpdate update);
  voxnav::GridUpdate obstacle_msg(voxnav::containers::GridUpdate update, std::uint32_t sequence) const;
  std_msgs::Header header() const;

  SubmapIntegratorConfig config_;
  submap::SubmapConfig submap_config_;
  submap::ProjectiveConfig projective_config_;
  submap::SubmapCollectionConfig collection_config_;
  bool is_projective_ = false;
  std::unique_ptr<tf2_ros::Buffer> tf_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;

  std::mutex mutex_;
  std::string map_frame_, odometry_frame_;
  std::map<std::uint32_t, voxnav::occupancy::MapContent> pending_;
  std::unique_ptr<submap::ProjectiveIntegrator> integrator_;
  submap::SubmapEntry open_;  ///< projective filling: the submap being filled
  std::unique_ptr<MergedMap> map_;
  voxnav::geometry::Pose T_W_O_ = voxnav::geometry::Pose::Identity();  ///< W starts as O
  std::uint32_t newest_id_ = 0;
  std::uint32_t sequence_ = 0;
  ros::Time last_stamp_;

  SubmapPictures pictures_;
  ros::Publisher submap_, obstacles_;
  ros::ServiceServer get_obstacles_, get_submaps_, save_, load_;
  ros::SteadyTimer snapshot_timer_;
  std::unique_ptr<Worker> worker_;  ///< stops before what its tasks use
  ros::Subscriber handover_, poses_, points_;
};

}  // namespace voxnav_ros
