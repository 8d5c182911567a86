// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ros/node_handle.h>

#include <memory>
#include <vector>

#include "submap_integrator_config.hpp"
#include "voxnav/submap/obstacle_map.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav_ros {

namespace submap = voxnav::submap;

/// The submaps and the obstacles that follow from them.
class MergedMap {
 public:
  MergedMap(const submap::SubmapCollectionConfig& config, double safety_distance_m);

  submap::SubmapCollection& collection() { return *collection_; }
  const submap::SubmapCollection& collection() const { return *collection_; }
  const submap::ObstacleMap& obstacles() const { return obstacles_; }
  /// Another set of submaps; what was there is forgotten with the next update.
  void replace(submap::SubmapCollection collection);
  void update();
  voxnav::containers::GridUpdate take_changes() { return obstacles_.take_changes(); }
  std::size_t memory_bytes() const { return collection_->memory_bytes() + obstacles_.memory_bytes(); }

 private:
  std::unique_ptr<submap::SubmapCollection> collection_;
  submap::ObstacleMap obstacles_;
};

/// What people see of the map. Made only while somebody listens.
class SubmapPictures {
 public:
  void advertise(ros::NodeHandle* nh);
  void publish(const MergedMap& map, const SubmapIntegratorConfig& config, const std_msgs::Header& header,
               const std::vector<std::uint32_t>& changed_ids);

 private:
  ros::Publisher obstacle_cloud_, occupancy_, mesh_, slice_;
};

}  // namespace voxnav_ros
