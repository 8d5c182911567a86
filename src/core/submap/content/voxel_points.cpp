// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/voxel_points.hpp"

#include <utility>

#include "base/check.hpp"

namespace voxnav::submap {

using occupancy::OccupiedVoxel;
using occupancy::VoxelPoint;

void VoxelPoints::add(const OccupiedVoxel& voxel) {
  believed_.push_back(voxel.believed);
  const bool is_observed = voxel.observed.hits > 0;
  is_observed_.push_back(is_observed);
  if (!is_observed) return;
  times_.push_back(voxel.observed_time);
  const bool differs = !(voxel.observed == voxel.believed);
  differs_.push_back(differs);
  if (differs) observed_.push_back(voxel.observed);
}

void VoxelPoints::finish() {
  believed_.shrink_to_fit();
  times_.shrink_to_fit();
  observed_.shrink_to_fit();
  is_observed_.finish();
  differs_.finish();
}

void VoxelPoints::move_to(std::vector<VoxelPoint> points) {
  VOXNAV_CHECK(all_observed() && points.size() == believed_.size(), "only observed points can be moved, and all");
  believed_ = std::move(points);
}

bool VoxelPoints::assign(Parts parts) {
  believed_ = std::move(parts.believed);
  times_ = std::move(parts.times);
  observed_ = std::move(parts.observed);
  return is_observed_.assign(std::move(parts.observed_words), believed_.size(), times_.size()) &&
         differs_.assign(std::move(parts.differing_words), times_.size(), observed_.size());
}

std::size_t VoxelPoints::memory_bytes() const {
  return (believed_.capacity() + observed_.capacity()) * sizeof(VoxelPoint) + times_.capacity() +
         is_observed_.memory_bytes() + differs_.memory_bytes();
}

}  // namespace voxnav::submap
