// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/evidence_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "submap/merged/evidence_merge.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

geometry::Aabb block_box(const Index3& block, double side_m) {
  return {Vec3(block.x, block.y, block.z) * side_m, Vec3(block.x + 1, block.y + 1, block.z + 1) * side_m};
}

}  // namespace

Vec3 point_in_W(const Index3& block, const SurfaceEvidence& evidence, double resolution_m) {
  const auto& mean = evidence.point.mean;
  return geometry::center_of(geometry::voxel_at(block, evidence.offset), resolution_m) +
         Vec3(mean[0], mean[1], mean[2]) * (resolution_m / 254.0);
}

EvidenceMap::EvidenceMap(const EvidenceRules& rules) : rules_(rules) {
  if (!(rules.resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
}

void EvidenceMap::integrate(const Index3& index, const PlacedSubmap& submap) {
  EvidenceBlock& block = blocks_[index];
  const PlacedPoints::Around around(submap.points(), index);
  if (!around.center() && block.points.empty() && is_decided(block.states)) return;
  EvidenceMerge(rules_, submap, around, &block).run();
  if (block.points.empty() && block.removed.empty() && block.states.all_unknown()) blocks_.erase(index);
}

void EvidenceMap::reset_block(const Index3& index) {
  const auto found = blocks_.find(index);
  if (found == blocks_.end()) return;
  found->second.states = {};
  found->second.points.clear();
  found->second.removed.clear();
}

const EvidenceBlock* EvidenceMap::find(const Index3& block) const {
  const auto it = blocks_.find(block);
  return it == blocks_.end() ? nullptr : &it->second;
}

VoxelState EvidenceMap::state(const Vec3& p_W) const {
  if (!((p_W.array().abs() / rules_.resolution_m) < 1073741824.0).all()) return VoxelState::kUnknown;
  const Index3 voxel = geometry::index_of(p_W, rules_.resolution_m);
  const EvidenceBlock* block = find(geometry::block_of(voxel));
  return block ? block->states.get(geometry::offset_in_block(voxel)) : VoxelState::kUnknown;
}

Vec3 EvidenceMap::point_of(const Index3& block, const SurfaceEvidence& evidence) const {
  return point_in_W(block, evidence, rules_.resolution_m);
}

std::optional<double> EvidenceMap::distance_to_surface(const Vec3& p_W, double max_distance_m) const {
  const auto nearest = nearest_surface(p_W, max_distance_m);
  if (!nearest) return std::nullopt;
  return nearest->distance_m;
}

std::optional<NearestSurface> EvidenceMap::nearest_surface(const Vec3& p_W, double max_distance_m) const {
  if (!((p_W.array().abs() / rules_.resolution_m) < 1073741824.0).all()) return std::nullopt;
  const double side_m = kBlockSide * rules_.resolution_m;
  const double limit = max_distance_m * max_distance_m;
  NearestSurface best{Vec3::Zero(), limit};  // distance_m holds the squared distance until the end
  const auto search = [&](const Index3& index) {
    const geometry::Aabb box = block_box(index, side_m);
    if ((p_W - p_W.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm() >= best.distance_m) return;
    const EvidenceBlock* block = find(index);
    if (!block) return;
    for (const SurfaceEvidence& evidence : block->points) {
      const Vec3 point = point_of(index, evidence);
      const double squared = (p_W - point).squaredNorm();
      if (squared < best.distance_m) best = {point, squared};
    }
  };
  // The block of the point is searched first, since a point in it rules out most of the other blocks.
  search(geometry::index_of(p_W, side_m));
  const Index3 low = geometry::index_of(p_W - Vec3::Constant(max_distance_m), side_m);
  const Index3 high = geometry::index_of(p_W + Vec3::Constant(max_distance_m), side_m);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) search({x, y, z});
    }
  }
  if (!(best.distance_m < limit)) return std::nullopt;
  best.distance_m = std::sqrt(best.distance_m);
  return best;
}

std::size_t EvidenceMap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.bucket_count() * sizeof(void*);
  for (const auto& entry : blocks_) {
    bytes += sizeof(entry) + 2 * sizeof(void*) +
             (entry.second.points.capacity() + entry.second.removed.capacity()) * sizeof(SurfaceEvidence);
  }
  return bytes;
}

}  // namespace voxnav::submap
