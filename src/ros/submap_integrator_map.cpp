// SPDX-License-Identifier: BSD-3-Clause
#include "submap_integrator_map.hpp"

#include <limits>

#include "voxnav_ros/submap_pictures.hpp"

namespace voxnav_ros {

MergedMap::MergedMap(const submap::SubmapCollectionConfig& config, double safety_distance_m)
    : collection_(std::make_unique<submap::SubmapCollection>(config)),
      obstacles_(config.resolution_m, safety_distance_m) {}

void MergedMap::replace(submap::SubmapCollection collection) {
  if (collection.config().resolution_m != collection_->config().resolution_m) {
    throw std::invalid_argument("the saved map has voxels of " + std::to_string(collection.config().resolution_m) +
                                " m, this node of " + std::to_string(collection_->config().resolution_m) + " m");
  }
  std::vector<voxnav::geometry::Index3> old;
  for (const auto& item : collection_->evidence().blocks()) old.push_back(item.first);
  obstacles_.mark_changed(old);
  collection_ = std::make_unique<submap::SubmapCollection>(std::move(collection));
}

void MergedMap::update() {
  obstacles_.mark_changed(collection_->update());
  obstacles_.update(collection_->evidence(), std::numeric_limits<std::size_t>::max());
}

void SubmapPictures::advertise(ros::NodeHandle* nh) {
  obstacle_cloud_ = nh->advertise<sensor_msgs::PointCloud2>("obstacle_cloud_out", 1, true);
  occupancy_ = nh->advertise<visualization_msgs::MarkerArray>("occupancy_markers_out", 1, true);
  mesh_ = nh->advertise<visualization_msgs::Marker>("mesh_out", 50);
  slice_ = nh->advertise<sensor_msgs::PointCloud2>("slice_out", 1, true);
}

void SubmapPictures::publish(const MergedMap& map, const SubmapIntegratorConfig& config, const std_msgs::Header& header,
                             const std::vector<std::uint32_t>& changed_ids) {
  const auto max_points = static_cast<std::size_t>(config.max_cloud_points);
  const submap::SubmapCollection& collection = map.collection();
  if (obstacle_cloud_.getNumSubscribers() > 0) {
    obstacle_cloud_.publish(occupied_cloud(map.obstacles().grid(), max_points, header));
  }
  if (occupancy_.getNumSubscribers() > 0) {
    occupancy_.publish(occupancy_markers(collection, header, static_cast<std::size_t>(config.max_markers)));
  }
  if (mesh_.getNumSubscribers() > 0) {
    for (const std::uint32_t id : changed_ids) {
      const submap::SubmapEntry* entry = collection.find(id);
      if (entry) mesh_.publish(mesh_marker(*entry, header, static_cast<std::size_t>(config.max_mesh_triangles)));
    }
  }
  const auto entries = collection.entries();
  if (slice_.getNumSubscribers() == 0 || entries.empty()) return;
  const submap::SubmapEntry& newest = *entries.back();
  voxnav::geometry::Pose T_W_B = newest.T_W_S;
  if (!newest.T_S_B.empty()) T_W_B = T_W_B * newest.T_S_B.back().pose;
  const auto bounds = newest.submap->known_bounds().transformed(newest.T_W_S);
  slice_.publish(distance_slice(collection.evidence(), bounds, T_W_B.translation().z() + config.slice_offset_m,
                                config.slice_max_distance_m, max_points, header));
}

}  // namespace voxnav_ros
