// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/placed_submap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "submap/merged/block_marks.hpp"
#include "submap/merged/leaf_placer.hpp"
#include "submap/voxel_walk.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Pose;
using geometry::Vec3;

std::uint8_t range_byte(const std::optional<double>& range_m) {
  return range_m ? static_cast<std::uint8_t>(std::min(255.0, 2.0 * *range_m)) : std::uint8_t{255};
}

bool turns_about_vertical(const Pose& T) {
  constexpr double kLevel = 1e-5;  // a tenth of a millimetre over ten metres
  const Eigen::Matrix3d R = T.linear();
  return std::max({std::abs(R(2, 0)), std::abs(R(2, 1)), std::abs(R(0, 2)), std::abs(R(1, 2))}) < kLevel;
}

/// The same transform from lengths in units of `unit_B` to lengths in units of `unit_A`.
Eigen::Affine3d in_units(const Pose& T_A_B, double unit_A, double unit_B) {
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear() = T_A_B.linear() * (unit_B / unit_A);
  out.translation() = T_A_B.translation() / unit_A;
  return out;
}

}  // namespace

PlacedSubmap::PlacedSubmap(const Submap& submap, std::uint32_t id, const Placement& placement, double resolution_m,
                           Knowledge knowledge, std::vector<Vec3> viewpoints_W)
    : field_(submap.field()),
      id_(id),
      knowledge_(knowledge),
      resolution_m_(resolution_m),
      submap_resolution_m_(submap.resolution_m()),
      placement_(placement),
      T_S_G_(submap.T_S_G()),
      viewpoints_W_(std::move(viewpoints_W)),
      is_level_(turns_about_vertical(placement.T_W_S * T_S_G_) && turns_about_vertical(placement.bend.T_S_begin) &&
                turns_about_vertical(placement.bend.T_S_end) && submap_resolution_m_ == resolution_m) {
  if (knowledge == Knowledge::kAll) placement_.bend = {};
  free_.resize(field_->num_blocks());
  place_leaves(submap.thin_leaves());
}

Pose PlacedSubmap::T_W_G_at(double phase) const {
  const bool is_rigid = placement_.bend.is_rigid();
  return is_rigid ? placement_.T_W_S * T_S_G_ : placement_.T_W_S * placement_.bend.at(phase) * T_S_G_;
}

/// For what is free and so has no time of its own: as the surface points of the same block, or of those below, lie on
/// average.
Eigen::Affine3d PlacedSubmap::T_G_W_of(const Index3& block) const {
  double phase = 0.5;
  for (const int step : {0, -1, -2, 1}) {
    if (placement_.bend.is_rigid()) break;
    const PlacedLeaves::Block* near = leaves_.find(block + Index3{0, 0, step});
    if (!near) continue;
    phase = near->phase();
    break;
  }
  return in_units(T_W_G_at(phase).inverse(Eigen::Isometry), submap_resolution_m_, resolution_m_);
}

void PlacedSubmap::place_leaves(const std::vector<bool>& is_thin) {
  std::vector<Eigen::Affine3d> T_W_G;
  const int num_times = placement_.bend.is_rigid() ? 1 : 256;
  for (int time = 0; time < num_times; ++time) {
    T_W_G.push_back(in_units(T_W_G_at(time / 255.0), resolution_m_, submap_resolution_m_));
  }
  LeafPlacer placer(T_W_G, &leaves_);
  leaves_.reserve(knowledge_ == Knowledge::kOwn ? field_->num_own_leaves() : field_->num_leaves(),
                  field_->num_blocks());
  for (std::size_t i = 0; i < field_->num_blocks(); ++i) {
    const Index3& block_G = field_->block_index(i);
    bool is_entered = false;
    const auto place = [&](int offset, const CompressedField::Leaf& leaf, std::size_t number,
                           std::uint8_t time = CompressedField::kUnknownTime) {
      if (!is_entered) placer.enter(block_G);
      is_entered = true;
      PlacedLeaf* placed = leaves_.next();
      placed->hits = leaf.hits;
      placed->range = 255;
      placed->is_thin = is_thin[number];
      if (placed->is_thin) {
        const Vec3 p = T_W_G[num_times > 1 ? time : 0] * surface_point(geometry::voxel_at(block_G, offset), leaf);
        placed->range = range_byte(range_to(p * resolution_m_));
      }
      placer.place(offset, leaf.mean, time, placed);
    };
    if (knowledge_ == Knowledge::kOwn) {
      field_->for_each_own_leaf_of(i, place);
    } else {
      field_->for_each_leaf_of(i, place);
    }
  }
  leaves_.sort();
}

/// Unpacked when first asked for: most of the air is known from other submaps already.
const Columns* PlacedSubmap::free_of(const Index3& block_G) const {
  const int position = field_->position_of(block_G);
  if (position < 0) return nullptr;
  const auto i = static_cast<std::size_t>(position);
  if (!free_[i]) {
    const bool is_own = knowledge_ == Knowledge::kOwn;
    free_[i] = std::make_unique<Columns>(is_own ? field_->own_free(i) : field_->columns(i).free);
  }
  return free_[i].get();
}

PlacedSubmap::FreeInBlock::FreeInBlock(const PlacedSubmap& submap, const Index3& block)
    : submap_(&submap), T_G_W_(submap.T_G_W_of(block)), origin_W_(Vec3(block.x, block.y, block.z) * kBlockSide) {
  if (submap.is_level_) window_.emplace(T_G_W_, block, [&](const Index3& b) { return submap.free_of(b); });
}

bool PlacedSubmap::FreeInBlock::is_free_at(const Vec3& p) const {
  const Index3 voxel = floor_index(T_G_W_ * (origin_W_ + p));
  const Columns* free = submap_->free_of(geometry::block_of(voxel));
  const int offset = geometry::offset_in_block(voxel);
  return free && (((*free)[static_cast<std::size_t>(offset & 255)] >> (offset >> 8)) & 1) != 0;
}

unsigned PlacedSubmap::FreeInBlock::at_tilted(const PlacedLeaf& leaf) const {
  const Vec3 p = local_point(leaf);
  return (is_free_at(p) ? 2u : 0u) | (is_free_at(p - Vec3(0.0, 0.0, 1.0)) ? 1u : 0u);
}

void PlacedSubmap::FreeInBlock::add_tilted(Columns* free) const {
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    if (!is_free_at(geometry::center_of(geometry::voxel_at({0, 0, 0}, offset), 1.0))) continue;
    (*free)[static_cast<std::size_t>(offset & 255)] |= static_cast<std::uint16_t>(1u << (offset >> 8));
  }
}

std::optional<double> PlacedSubmap::range_to(const Vec3& p_W) const {
  if (viewpoints_W_.empty()) return std::nullopt;
  double squared = std::numeric_limits<double>::infinity();
  for (const Vec3& view : viewpoints_W_) squared = std::min(squared, (view - p_W).squaredNorm());
  return std::sqrt(squared);
}

namespace {

/// Boxes around the blocks of a submap: all blocks are turned alike, so that of the first one, moved.
class PlacedBox {
 public:
  PlacedBox(const Pose& T_W_G, double side_G)
      : T_W_G_(T_W_G), side_G_(side_G), unit_(geometry::Aabb{Vec3::Zero(), Vec3::Constant(side_G)}.transformed(T_W_G)) {
    unit_.min -= T_W_G.translation();
    unit_.max -= T_W_G.translation();
  }
  void extend(const Index3& block, geometry::Aabb* box) const {
    const Vec3 origin = T_W_G_ * (Vec3(block.x, block.y, block.z) * side_G_);
    box->extend(origin + unit_.min);
    box->extend(origin + unit_.max);
  }

 private:
  Pose T_W_G_;
  double side_G_;
  geometry::Aabb unit_;
};

}  // namespace

std::vector<Pose> extremes(const Placement& placement) {
  if (placement.bend.is_rigid()) return {placement.T_W_S};
  return {placement.T_W_S, placement.T_W_S * placement.bend.T_S_begin, placement.T_W_S * placement.bend.T_S_end};
}

std::vector<Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                              Knowledge knowledge) {
  const double side_G = kBlockSide * submap.resolution_m();
  const double side_W = kBlockSide * resolution_m;
  std::vector<Index3> out;
  const auto field = submap.field();
  std::vector<PlacedBox> boxes;
  for (const Pose& T_W_S : extremes(placement)) boxes.emplace_back(T_W_S * submap.T_S_G(), side_G);
  for (std::size_t i = 0; i < field->num_blocks(); ++i) {
    if (knowledge == Knowledge::kOwn && !field->has_own(i)) continue;
    const Index3& block = field->block_index(i);
    geometry::Aabb box;
    for (const PlacedBox& placed : boxes) placed.extend(block, &box);
    const Index3 low = floor_index(box.min / side_W);
    const Index3 high = floor_index(box.max / side_W);
    for (int z = low.z; z <= high.z; ++z) {
      for (int y = low.y; y <= high.y; ++y) {
        for (int x = low.x; x <= high.x; ++x) out.push_back({x, y, z});
      }
    }
  }
  sort_unique(&out);
  return out;
}

}  // namespace voxnav::submap
