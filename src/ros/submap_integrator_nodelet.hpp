// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mrs_msgs/String.h>
#include <sensor_msgs/PointCloud2.h>
#include <std_srvs/Trigger.h>
#include <tf2_ros/transform_listener.h>

#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "odometry_origins.hpp"
#include "submap_integrator_config.hpp"
#include "submap_integrator_map.hpp"
#include "submap_octomap.hpp"
#include "submap_picture_topics.hpp"
#include "voxnav/FinishedSubmap.h"
#include "voxnav/GetGrid.h"
#include "voxnav/GetSubmaps.h"
#include "voxnav/Handover.h"
#include "voxnav/OdometryOrigin.h"
#include "voxnav/SubmapPoses.h"
#include "voxnav/pipeline/submap_assembler.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/messages.hpp"
#include "voxnav_ros/nodelet_base.hpp"
#include "voxnav_ros/worker.hpp"

namespace voxnav_ros {

/// The nodelet that takes handovers (or clouds) and publishes finished submaps and obstacles. Callbacks only queue
/// tasks; one worker thread finishes submaps and keeps the merged map, so that no sensor waits for it. The mutex guards
/// all members that are declared after it.
class SubmapIntegratorNodelet : public NodeletBase {
 public:
  SubmapIntegratorNodelet() : NodeletBase("SubmapIntegrator") {}

 private:
  void initialize() override;
  void start() override;
  void make_assembler();
  void advertise();
  void enqueue(const char* what, std::function<void()> task);
  void refuse(const std::string& what, const std::string& reason);

  void on_handover(const msg::HandoverConstPtr& msg);
  void on_poses(const msg::SubmapPosesConstPtr& msg);
  void on_origin(const msg::OdometryOriginConstPtr& msg);
  void on_points(const sensor_msgs::PointCloud2ConstPtr& msg);
  void on_snapshot_time(const ros::SteadyTimerEvent&);
  void on_picture_time(const ros::SteadyTimerEvent&);
  void on_octomap_time(const ros::SteadyTimerEvent&);
  bool on_get_obstacles(voxnav::GetGrid::Request&, voxnav::GetGrid::Response& response);
  bool on_get_submaps(voxnav::GetSubmaps::Request&, voxnav::GetSubmaps::Response& response);
  bool on_save(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_load(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_merge(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);
  bool on_reset(std_srvs::Trigger::Request& request, std_srvs::Trigger::Response& response);
  bool on_export(mrs_msgs::String::Request& request, mrs_msgs::String::Response& response);

  // These run on any thread and without the mutex, so that files are written while the worker goes on.
  submap::SubmapCollection copy_of_map();
  std::size_t save(const std::string& directory);
  std::string save_octomap(const std::string& path);
  submap::SubmapCollection load(const std::string& path, std::vector<std::string>* problems) const;
  std::string take_over(submap::SubmapCollection loaded, const std::vector<std::string>& problems);
  void autosave();

  // These run on the worker, which holds the mutex.
  bool was_reset_after(const ros::Time& stamp) const;
  void take_handover(const voxnav::pipeline::Handover& handover, const std::string& frame);
  void take_origin(const msg::OdometryOrigin& msg);
  voxnav::geometry::Pose into_origin(const std::string& frame);
  void close_map(const std::string& frame, const std::string& reason);
  void express_now(const submap::SubmapEntry& entry, msg::FinishedSubmap* msg) const;
  void take_poses(const msg::SubmapPoses& msg);
  void integrate(const sensor_msgs::PointCloud2& msg);
  void close_submap_of_clouds();
  void add(submap::SubmapEntry entry);
  void refresh(const ros::Time& stamp);
  void continue_from(const submap::SubmapCollection& loaded);
  std::string show_loaded(std::size_t num_loaded, const std::vector<std::string>& problems);
  void publish_obstacles(voxnav::containers::GridUpdate update);
  msg::GridUpdate obstacle_msg(voxnav::containers::GridUpdate update, std::uint32_t sequence) const;
  std_msgs::Header header() const;

  SubmapIntegratorConfig config_;
  submap::SubmapConfig submap_config_;
  submap::ProjectiveConfig projective_config_;
  submap::SubmapCollectionConfig collection_config_;
  std::unique_ptr<tf2_ros::Buffer> tf_;
  std::unique_ptr<tf2_ros::TransformListener> tf_listener_;

  std::mutex mutex_;
  std::string map_frame_;
  OdometryOrigins origins_;
  bool has_origin_ = false;  ///< whether a handover, or the mapper, has named the origin
  std::unique_ptr<voxnav::pipeline::SubmapAssembler> assembler_;
  std::unique_ptr<MergedMap> map_;
  voxnav::geometry::Pose T_W_O_ = voxnav::geometry::Pose::Identity();  ///< identity at first: W begins as O
  std::uint32_t newest_id_ = 0;
  std::uint32_t flight_ = 0;               ///< flight number of the next submaps
  std::uint32_t first_id_ = 0;             ///< lowest id above those of all loaded submaps
  std::optional<std::uint32_t> id_shift_;  ///< added to the ids of new submaps; if absent, the next one determines it
  std::uint32_t sequence_ = 0;
  ros::Time last_stamp_;
  std::optional<ros::Time> reset_at_;  ///< when the map was last cleared by the service

  std::unique_ptr<SubmapPictures> pictures_;
  SubmapOctomap octomap_;
  ros::Publisher submap_, obstacles_;
  ros::ServiceServer get_obstacles_, get_submaps_, save_, load_, merge_, export_, reset_;
  ros::SteadyTimer snapshot_timer_, picture_timer_, octomap_timer_;
  std::mutex save_mutex_;                   ///< held while the map is saved: one save at a time
  std::unique_ptr<Worker> saver_, worker_;  ///< destroyed before what their tasks use
  ros::Subscriber handover_, origin_, poses_, points_;
};

}  // namespace voxnav_ros
