// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <stdexcept>

#include "submap/merged/collection_parts.hpp"
#include "submap/voxel_walk.hpp"
#include "voxnav/submap/obstacle_map.hpp"

namespace voxnav::submap {

using geometry::Index3;
using geometry::Vec3;

std::vector<geometry::Vec3f> SubmapCollection::occupied_points() {
  update();
  std::vector<Index3> order;
  for (const auto& item : evidence().blocks()) order.push_back(item.first);
  std::sort(order.begin(), order.end());
  std::vector<geometry::Vec3f> out;
  for (const Index3& index : order) {
    for (const SurfaceEvidence& point : evidence().find(index)->points) {
      out.emplace_back(evidence().point_of(index, point).cast<float>());
    }
  }
  return out;
}

containers::StateGrid SubmapCollection::obstacles(double safety_distance_m) {
  update();
  ObstacleMap obstacles(config().resolution_m, safety_distance_m);
  std::vector<Index3> all;
  for (const auto& item : evidence().blocks()) all.push_back(item.first);
  obstacles.mark_changed(all);
  obstacles.update(evidence(), std::numeric_limits<std::size_t>::max());
  return obstacles.grid();
}

containers::VoxelState SubmapCollection::state(const Vec3& p_W) {
  update();
  return evidence().state(p_W);
}

std::optional<double> SubmapCollection::distance(const Vec3& p_W, double max_distance_m) {
  update();
  if (evidence().state(p_W) == containers::VoxelState::kUnknown) return std::nullopt;
  return evidence().distance_to_surface(p_W, max_distance_m).value_or(max_distance_m);
}

std::optional<Vec3> SubmapCollection::gradient(const Vec3& p_W, double max_distance_m) {
  update();
  if (evidence().state(p_W) == containers::VoxelState::kUnknown) return std::nullopt;
  const auto nearest = evidence().nearest_surface(p_W, max_distance_m);
  if (!nearest || nearest->distance_m == 0.0) return Vec3(Vec3::Zero());
  return Vec3((p_W - nearest->point_W) / nearest->distance_m);
}

SubmapCollection::Ray SubmapCollection::cast_ray(const Vec3& a_W, const Vec3& b_W) {
  constexpr double kLongest_m = 1e4;
  if (!a_W.allFinite() || !b_W.allFinite() || !((b_W - a_W).norm() < kLongest_m) || a_W.cwiseAbs().maxCoeff() > 1e7)
    throw std::invalid_argument("a ray needs finite ends less than 10 km apart");
  update();
  Ray out;
  const double length_m = (b_W - a_W).norm();
  VoxelWalk walk(a_W / config().resolution_m, b_W / config().resolution_m);
  Index3 at{1 << 30, 0, 0};
  const EvidenceBlock* block = nullptr;
  for (int axis = 0; axis >= 0; axis = walk.advance()) {
    const Index3 voxel = walk.index();
    if (geometry::block_of(voxel) != at) {
      at = geometry::block_of(voxel);
      block = evidence().find(at);
    }
    out.state = block ? block->states.get(geometry::offset_in_block(voxel)) : containers::VoxelState::kUnknown;
    out.distance_m = walk.entered() * length_m;
    if (out.state != containers::VoxelState::kFree) return out;
  }
  out.distance_m = length_m;
  return out;
}

std::vector<SceneChange> SubmapCollection::changes(std::size_t min_voxels) {
  update();
  return scene_changes(evidence(), min_voxels);
}

std::size_t SubmapCollection::memory_bytes() const {
  return sizeof(*this) + sizeof(Parts) + parts_->merge.memory_bytes() + parts_->store.memory_bytes();
}

}  // namespace voxnav::submap
