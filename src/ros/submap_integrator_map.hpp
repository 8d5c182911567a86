// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "voxnav/submap/obstacle_map.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav_ros {

namespace submap = voxnav::submap;

/// The submaps, the merged map and its obstacles.
class MergedMap {
 public:
  MergedMap(const submap::SubmapCollectionConfig& config, double safety_distance_m);

  submap::SubmapCollection& collection() { return *collection_; }
  const submap::SubmapCollection& collection() const { return *collection_; }
  const submap::ObstacleMap& obstacles() const { return obstacles_; }
  /// Replaces the submaps by others; after the next update nothing of the present ones is left.
  /// @throws std::invalid_argument if the voxels of the new ones have another size
  void replace(submap::SubmapCollection collection);
  /// Brings the merged map and the obstacles up to date. @return blocks whose evidence changed
  std::vector<voxnav::geometry::Index3> update();
  voxnav::containers::GridUpdate take_changes() { return obstacles_.take_changes(); }
  std::size_t memory_bytes() const { return collection_->memory_bytes() + obstacles_.memory_bytes(); }

 private:
  std::unique_ptr<submap::SubmapCollection> collection_;
  submap::ObstacleMap obstacles_;
  std::vector<voxnav::geometry::Index3> replaced_;  ///< blocks of a collection that was replaced since the last update
};

}  // namespace voxnav_ros
