// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/evidence_map.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "voxnav/submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using containers::State;
using geometry::Index3;
using geometry::kBlockSide;
using geometry::kBlockVolume;
using geometry::Pose;
using geometry::Vec3;

geometry::Aabb block_box(const Index3& block, double side_m) {
  return {Vec3(block.x, block.y, block.z) * side_m, Vec3(block.x + 1, block.y + 1, block.z + 1) * side_m};
}

}  // namespace

EvidenceMap::EvidenceMap(double resolution_m, double clearing_distance_m)
    : resolution_m_(resolution_m), clearing_distance_m_(clearing_distance_m) {
  if (!(resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
}

void EvidenceMap::integrate(const Index3& index, const Submap& submap, std::uint32_t submap_id, const Pose& T_W_S) {
  const Pose T_W_G = T_W_S * submap.T_S_G();
  const Pose T_G_W = T_W_G.inverse(Eigen::Isometry);
  EvidenceBlock& block = blocks_[index];
  drop_cleared(index, submap, T_G_W, &block);
  take_free(index, submap, T_G_W, &block);
  take_leaves(index, submap, submap_id, T_W_G, &block);
  for (const EvidenceLeaf& leaf : block.leaves) block.states.set(leaf.offset, State::kOccupied);
  if (block.leaves.empty() && block.states.all_unknown()) blocks_.erase(index);
}

void EvidenceMap::drop_cleared(const Index3& index, const Submap& submap, const Pose& T_G_W,
                               EvidenceBlock* block) const {
  const CompressedField& field = submap.field();
  const double clearing = clearing_distance_m_ / submap.resolution_m();
  const auto is_gone = [&](const EvidenceLeaf& leaf) {
    const Vec3 p = T_G_W * point_of(index, leaf) / submap.resolution_m();
    if (field.state(floor_index(p)) != State::kFree) return false;
    return !field.nearest(p, clearing, CompressedField::Target::kSurfacePoint);
  };
  // A voxel without leaves becomes unknown here; the free space of the newer submap is taken next.
  for (const EvidenceLeaf& leaf : block->leaves) block->states.set(leaf.offset, State::kUnknown);
  block->leaves.erase(std::remove_if(block->leaves.begin(), block->leaves.end(), is_gone), block->leaves.end());
}

void EvidenceMap::take_free(const Index3& index, const Submap& submap, const Pose& T_G_W, EvidenceBlock* block) const {
  const double scale = resolution_m_ / submap.resolution_m();
  const Vec3 first = T_G_W * geometry::center_of(geometry::voxel_at(index, 0), resolution_m_) / submap.resolution_m();
  const Eigen::Matrix3d step = T_G_W.linear() * scale;
  CompressedField::Reader reader(submap.field());
  for (int row = 0; row < kBlockSide * kBlockSide; ++row) {
    Vec3 p = first + step * Vec3(0, row & 15, row >> 4);
    for (int x = 0; x < kBlockSide; ++x, p += step.col(0)) {
      if (reader.state(floor_index(p)) == State::kFree) block->states.set(row * kBlockSide + x, State::kFree);
    }
  }
}

void EvidenceMap::take_leaves(const Index3& index, const Submap& submap, std::uint32_t submap_id, const Pose& T_W_G,
                              EvidenceBlock* block) const {
  const geometry::Aabb box = block_box(index, kBlockSide * resolution_m_);
  const geometry::Aabb box_G = box.transformed(T_W_G.inverse(Eigen::Isometry));
  const CompressedField& field = submap.field();
  const double side_m = kBlockSide * submap.resolution_m();
  const Index3 low = geometry::index_of(box_G.min, side_m);
  const Index3 high = geometry::index_of(box_G.max, side_m);
  const std::size_t first_new = block->leaves.size();
  containers::StateBlock seen;
  const auto take = [&](const Index3& voxel, const CompressedField::Leaf& leaf) {
    const Vec3 p = T_W_G * (surface_point(voxel, leaf) * submap.resolution_m()) / resolution_m_;
    const Index3 at = floor_index(p);
    if (geometry::block_of(at) != index) return;
    const Vec3 mean = (p - geometry::center_of(at, 1.0)) * 254.0;
    const auto byte = [](double v) {
      return static_cast<std::int8_t>(std::lround(std::min(127.0, std::max(-127.0, v))));
    };
    const auto offset = static_cast<std::uint16_t>(geometry::offset_in_block(at));
    block->leaves.push_back({offset, {byte(mean.x()), byte(mean.y()), byte(mean.z())}, submap_id});
    seen.set(offset, State::kOccupied);
  };
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) field.for_each_leaf_in({x, y, z}, take);
    }
  }
  const auto first = block->leaves.begin();
  const auto end_of_old = first + static_cast<std::ptrdiff_t>(first_new);
  const auto kept = std::remove_if(first, end_of_old,
                                   [&](const EvidenceLeaf& leaf) { return seen.get(leaf.offset) == State::kOccupied; });
  block->leaves.erase(kept, end_of_old);
}

const EvidenceBlock* EvidenceMap::find(const Index3& block) const {
  const auto it = blocks_.find(block);
  return it == blocks_.end() ? nullptr : &it->second;
}

State EvidenceMap::state(const Vec3& p_W) const {
  if (!((p_W.array().abs() / resolution_m_) < 1073741824.0).all()) return State::kUnknown;
  const Index3 voxel = geometry::index_of(p_W, resolution_m_);
  const EvidenceBlock* block = find(geometry::block_of(voxel));
  return block ? block->states.get(geometry::offset_in_block(voxel)) : State::kUnknown;
}

Vec3 EvidenceMap::point_of(const Index3& block, const EvidenceLeaf& leaf) const {
  const Vec3 mean(leaf.mean[0], leaf.mean[1], leaf.mean[2]);
  return geometry::center_of(geometry::voxel_at(block, leaf.offset), resolution_m_) + mean * (resolution_m_ / 254.0);
}

std::optional<double> EvidenceMap::distance_to_surface(const Vec3& p_W, double max_distance_m) const {
  const double side_m = kBlockSide * resolution_m_;
  double best = max_distance_m * max_distance_m;
  bool found = false;
  const Index3 low = geometry::index_of(p_W - Vec3::Constant(max_distance_m), side_m);
  const Index3 high = geometry::index_of(p_W + Vec3::Constant(max_distance_m), side_m);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) {
        const geometry::Aabb box = block_box({x, y, z}, side_m);
        if ((p_W - p_W.cwiseMax(box.min).cwiseMin(box.max)).squaredNorm() >= best) continue;
        const EvidenceBlock* block = find({x, y, z});
        if (!block) continue;
        for (const EvidenceLeaf& leaf : block->leaves) {
          const double squared = (p_W - point_of({x, y, z}, leaf)).squaredNorm();
          if (squared >= best) continue;
          best = squared;
          found = true;
        }
      }
    }
  }
  if (!found) return std::nullopt;
  return std::sqrt(best);
}

std::size_t EvidenceMap::memory_bytes() const {
  std::size_t bytes = sizeof(*this) + blocks_.bucket_count() * sizeof(void*);
  for (const auto& entry : blocks_) {
    bytes += sizeof(entry) + 2 * sizeof(void*) + entry.second.leaves.capacity() * sizeof(EvidenceLeaf);
  }
  return bytes;
}

std::vector<Index3> footprint(const Submap& submap, const Pose& T_W_S, double resolution_m) {
  const Pose T_W_G = T_W_S * submap.T_S_G();
  const double side_G = kBlockSide * submap.resolution_m();
  const double side_W = kBlockSide * resolution_m;
  std::vector<Index3> out;
  for (std::size_t i = 0; i < submap.field().num_blocks(); ++i) {
    const geometry::Aabb box = block_box(submap.field().block_index(i), side_G).transformed(T_W_G);
    const Index3 low = geometry::index_of(box.min, side_W);
    const Index3 high = geometry::index_of(box.max, side_W);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) out.push_back({x, y, z});
      }
    }
  }
  std::sort(out.begin(), out.end());
  out.erase(std::unique(out.begin(), out.end()), out.end());
  return out;
}

}  // namespace voxnav::submap
