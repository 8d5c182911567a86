// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/placed_submap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "submap/merged/point_placer.hpp"
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

/// Rescales a transform to take lengths in units of `unit_B` to lengths in units of `unit_A`.
Eigen::Affine3d in_units(const Pose& T_A_B, double unit_A, double unit_B) {
  Eigen::Affine3d out = Eigen::Affine3d::Identity();
  out.linear() = T_A_B.linear() * (unit_B / unit_A);
  out.translation() = T_A_B.translation() / unit_A;
  return out;
}

}  // namespace

PlacedSubmap::PlacedSubmap(const Submap& submap, std::uint32_t id, const Placement& placement, double resolution_m,
                           Knowledge knowledge, std::vector<Vec3> viewpoints_W)
    : content_(submap.content()),
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
  free_.resize(content_->states().size());
  place_points(submap.thin_voxels());
}

Pose PlacedSubmap::T_W_G_at(double phase) const {
  const bool is_rigid = placement_.bend.is_rigid();
  return is_rigid ? placement_.T_W_S * T_S_G_ : placement_.T_W_S * placement_.bend.at(phase) * T_S_G_;
}

/// Returns the transform for free voxels, which have no time: that of the mean phase of the surface points in the same
/// block, or else in the block below.
Eigen::Affine3d PlacedSubmap::T_G_W_of(const Index3& block) const {
  double phase = 0.5;
  for (const int step : {0, -1, -2, 1}) {
    if (placement_.bend.is_rigid()) break;
    const PlacedPoints::Block* near = points_.find(block + Index3{0, 0, step});
    if (!near) continue;
    phase = near->phase();
    break;
  }
  return in_units(T_W_G_at(phase).inverse(Eigen::Isometry), submap_resolution_m_, resolution_m_);
}

void PlacedSubmap::place_points(const std::vector<bool>& is_thin) {
  std::vector<Eigen::Affine3d> T_W_G;
  const int num_times = placement_.bend.is_rigid() ? 1 : 256;
  T_W_G.reserve(static_cast<std::size_t>(num_times));
  for (int time = 0; time < num_times; ++time) {
    T_W_G.push_back(in_units(T_W_G_at(time / 255.0), resolution_m_, submap_resolution_m_));
  }
  PointPlacer placer(T_W_G, &points_);
  const BlockStates& states = content_->states();
  const bool is_observed_only = knowledge_ == Knowledge::kObserved;
  points_.reserve(is_observed_only ? content_->points().num_observed() : content_->points().size(), states.size());
  for (std::size_t i = 0; i < states.size(); ++i) {
    const Index3& block_G = states.index(i);
    bool is_entered = false;
    content_->for_each_voxel(i, [&](const occupancy::OccupiedVoxel& voxel, std::size_t number) {
      if (is_observed_only && voxel.observed.hits == 0) return;
      if (!is_entered) placer.enter(block_G);
      is_entered = true;
      const std::uint8_t time = is_observed_only ? voxel.observed_time : occupancy::kUnknownTime;
      SurfaceEvidence* placed = points_.next();
      placed->point = is_observed_only ? voxel.observed : voxel.believed;
      placed->submap_id = id_;
      placed->is_new = false;
      placed->is_doubted = false;
      placed->range = 255;
      placed->is_thin = is_thin[number];
      if (placed->is_thin) {
        const Vec3 p =
            T_W_G[num_times > 1 ? time : 0] * surface_point(geometry::voxel_at(block_G, voxel.offset), placed->point);
        placed->range = range_byte(range_to(p * resolution_m_));
      }
      placer.place(voxel.offset, time, placed);
    });
  }
  points_.sort();
}

/// Returns the free voxels of a block, which are unpacked when first asked for: most blocks of air are never asked for,
/// as they are known to be free from other submaps.
const Columns* PlacedSubmap::free_of(const Index3& block_G) const {
  const BlockStates& states = content_->states();
  const auto position = states.find(block_G);
  if (!position) return nullptr;
  std::unique_ptr<Columns>& free = free_[*position];
  if (!free) {
    const bool is_observed_only = knowledge_ == Knowledge::kObserved;
    free =
        std::make_unique<Columns>(is_observed_only ? states.observed_free(*position) : states.columns(*position).free);
  }
  return free.get();
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

FreeAt PlacedSubmap::FreeInBlock::at_tilted(const SurfaceEvidence& evidence) const {
  const Vec3 p = local_point(evidence);
  const Vec3 step(0.0, 0.0, 1.0);
  return {is_free_at(p), is_free_at(p - step), is_free_at(p + step)};
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

}  // namespace voxnav::submap
