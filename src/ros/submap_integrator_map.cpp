// SPDX-License-Identifier: BSD-3-Clause
#include "submap_integrator_map.hpp"

#include <limits>

namespace voxnav_ros {

MergedMap::MergedMap(const submap::SubmapCollectionConfig& config, double safety_distance_m)
    : collection_(std::make_unique<submap::SubmapCollection>(config)),
      obstacles_(config.resolution_m, safety_distance_m) {}

void MergedMap::replace(submap::SubmapCollection collection) {
  if (collection.config().resolution_m != collection_->config().resolution_m) {
    throw std::invalid_argument("the saved map has voxels of " + std::to_string(collection.config().resolution_m) +
                                " m, this node of " + std::to_string(collection_->config().resolution_m) + " m");
  }
  for (const auto& item : collection_->evidence().blocks()) replaced_.push_back(item.first);
  collection_ = std::make_unique<submap::SubmapCollection>(std::move(collection));
}

std::vector<voxnav::geometry::Index3> MergedMap::update() {
  std::vector<voxnav::geometry::Index3> changed = collection_->update();
  changed.insert(changed.end(), replaced_.begin(), replaced_.end());
  replaced_.clear();
  obstacles_.mark_changed(changed);
  obstacles_.update(collection_->evidence(), std::numeric_limits<std::size_t>::max());
  return changed;
}

}  // namespace voxnav_ros
