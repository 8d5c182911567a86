// SPDX-License-Identifier: BSD-3-Clause
#include "pipeline/navigation_view.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::pipeline {

using containers::StateBlock;
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;
using planning::BlockMask;

namespace {
constexpr int kSide = geometry::kBlockSide;
/// A voxel whose centre is at a limit of height may be entered, whatever rounding makes of it.
constexpr double kTolerance = 1e-9;

/// The limits are distances of the centres of voxels from the upper face of the terrain's voxel.
HeightLimits limits_of(const NavigationMapConfig& config, double resolution_m) {
  HeightLimits out;
  if (config.min_height_m > 0.0) {
    out.low = static_cast<int>(std::ceil(0.5 + config.min_height_m / resolution_m - kTolerance));
  }
  if (config.max_height_m > 0.0) {
    out.high = static_cast<int>(std::floor(0.5 + config.max_height_m / resolution_m + kTolerance));
  }
  return out;
}

}  // namespace

NavigationView::NavigationView(const NavigationMapConfig& config, Content content)
    : config_(config),
      content_(std::move(content)),
      heights_(limits_of(config, content_.local->resolution_m())),
      min_altitude_m_(config.min_altitude_m),
      max_altitude_m_(config.max_altitude_m) {
  const Vec3& p = content_.vehicle_O;
  const Vec3 footprint(config.footprint_radius_m, config.footprint_radius_m, config.footprint_half_height_m);
  footprint_ = {p - footprint, p + footprint};
  // Altitudes are limits of the map frame, which is upright in O as well.
  const double shift = content_.T_W_O.translation().z();
  bounds_.min = Vec3(p.x() - config.range_m, p.y() - config.range_m, 0.0);
  bounds_.max = Vec3(p.x() + config.range_m, p.y() + config.range_m, 0.0);
  if (content_.fences != nullptr && content_.fences->fences().area()) limit_to_area(*content_.fences->fences().area());
  bounds_.min.z() = min_altitude_m_ - shift;
  bounds_.max.z() = max_altitude_m_ - shift;
  // A vehicle below or above the limits must be able to come back.
  const double edge = content_.local->resolution_m();
  bounds_.min.z() = std::min(bounds_.min.z(), p.z() - edge);
  bounds_.max.z() = std::max(bounds_.max.z(), p.z() + edge);
}

void NavigationView::limit_to_area(const planning::Prism& area) {
  for (int axis = 0; axis < 2; ++axis) {
    double low = area.outline.front()[axis], high = low;
    for (const auto& corner : area.outline) {
      low = std::min(low, corner[axis]);
      high = std::max(high, corner[axis]);
    }
    bounds_.min[axis] = std::max(bounds_.min[axis], low);
    bounds_.max[axis] = std::min(bounds_.max[axis], high);
  }
  // Altitudes are those of the centres of voxels, and paths touch the whole of them.
  const double margin_m = config_.area_margin_m + 0.5 * content_.local->resolution_m();
  const double shift = content_.T_W_O.translation().z();
  min_altitude_m_ = std::max(min_altitude_m_, area.min_z + shift + margin_m);
  max_altitude_m_ = std::min(max_altitude_m_, area.max_z + shift - margin_m);
}

bool NavigationView::is_in_footprint(const Index3& voxel) const {
  const Vec3 offset = geometry::center_of(voxel, resolution_m()) - content_.vehicle_O;
  return offset.head<2>().squaredNorm() <= config_.footprint_radius_m * config_.footprint_radius_m &&
         std::abs(offset.z()) <= config_.footprint_half_height_m;
}

VoxelState NavigationView::state(const Index3& voxel) const {
  if (content_.sightings != nullptr && content_.sightings->is_hit(voxel)) return VoxelState::kOccupied;
  const VoxelState known = content_.local->state(voxel);
  return known == VoxelState::kUnknown && is_in_footprint(voxel) ? VoxelState::kFree : known;
}

geometry::Aabb NavigationView::box_of(const Index3& block) const {
  const double side = kSide * resolution_m();
  const Vec3 corner = Vec3(block.x, block.y, block.z) * side;
  return {corner, corner + Vec3::Constant(side)};
}

const StateBlock* NavigationView::block(const Index3& block, StateBlock* scratch) const {
  const StateBlock* known = content_.local->find_block(block);
  const bool has_hits = content_.sightings != nullptr && content_.sightings->has_hits(block);
  const bool has_footprint = box_of(block).intersects(footprint_);
  if (!has_hits && !has_footprint) return known;
  *scratch = known != nullptr ? *known : StateBlock{};
  if (has_hits) content_.sightings->add_hits(block, scratch);
  if (!has_footprint) return scratch;
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    if (scratch->get(offset) == VoxelState::kUnknown && is_in_footprint(geometry::voxel_at(block, offset))) {
      scratch->set(offset, VoxelState::kFree);
    }
  }
  return scratch;
}

void NavigationView::add_blocks(const geometry::Aabb& box, std::vector<Index3>* out) const {
  if (!box.intersects(bounds_)) return;
  const double side = kSide * resolution_m();
  const Index3 low = geometry::index_of(box.min.cwiseMax(bounds_.min), side);
  const Index3 high = geometry::index_of(box.max.cwiseMin(bounds_.max), side);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) out->push_back({x, y, z});
    }
  }
}

std::vector<Index3> NavigationView::known_blocks() const {
  std::vector<Index3> out = content_.local->sorted_block_indices();
  add_blocks(footprint_, &out);
  // The vehicle may have widened the bounds beyond the altitudes, so that blocks without content hold forbidden
  // voxels.
  const double shift = content_.T_W_O.translation().z();
  const Vec3 low(bounds_.min.x(), bounds_.min.y(), min_altitude_m_ - shift);
  const Vec3 high(bounds_.max.x(), bounds_.max.y(), max_altitude_m_ - shift);
  if (bounds_.min.z() < low.z()) add_blocks({bounds_.min, {high.x(), high.y(), low.z()}}, &out);
  if (bounds_.max.z() > high.z()) add_blocks({{low.x(), low.y(), high.z()}, bounds_.max}, &out);
  if (content_.fences != nullptr) content_.fences->add_edge_blocks(bounds_, &out);
  if (heights_.low || heights_.high) add_height_blocks(&out);
  if (content_.sightings != nullptr) {
    for (const geometry::Aabb& box : content_.sightings->boxes()) add_blocks(box, &out);
  }
  if (content_.obstacles == nullptr) return out;
  for (const geometry::Aabb& box : content_.obstacles->block_boxes()) add_blocks(box, &out);
  return out;
}

bool NavigationView::forbid_altitudes(const Index3& block, BlockMask* hard) const {
  bool is_any = false;
  const double shift = content_.T_W_O.translation().z();
  const bool has_footprint = box_of(block).intersects(footprint_);
  for (int z = 0; z < kSide; ++z) {
    const double altitude = (block.z * kSide + z + 0.5) * resolution_m() + shift;
    if (altitude >= min_altitude_m_ && altitude <= max_altitude_m_) continue;
    if (!has_footprint) {
      hard->set_layer(z);
      is_any = true;
      continue;
    }
    for (int offset = z * kSide * kSide; offset < (z + 1) * kSide * kSide; ++offset) {
      if (has_footprint && is_in_footprint(geometry::voxel_at(block, offset))) continue;
      hard->set(offset);
      is_any = true;
    }
  }
  return is_any;
}

const TerrainMap& NavigationView::terrain() const {
  std::call_once(terrain_once_,
                 [this] { terrain_ = content_.terrain->terrain_of(*content_.local, content_.vehicle_O); });
  return *terrain_;
}

/// Appends the blocks over and under known terrain, because limits of height forbid voxels of blocks without content.
void NavigationView::add_height_blocks(std::vector<Index3>* out) const {
  if (bounds_.empty()) return;
  const double side = kSide * resolution_m();
  const Index3 low = geometry::index_of(bounds_.min, side), high = geometry::index_of(bounds_.max, side);
  for (const auto& [index, there] : terrain().columns()) {
    const bool is_inside = index.x >= low.x && index.x <= high.x && index.y >= low.y && index.y <= high.y;
    if (!is_inside || !there->is_known_anywhere()) continue;
    for (int z = low.z; z <= high.z; ++z) out->push_back({index.x, index.y, z});
  }
}

/// Takes the voxels out of a mask through which a vehicle outside the limits of height comes back.
void NavigationView::allow_way_of_vehicle(const Index3& block, const TerrainColumn& there, BlockMask* mask) const {
  const double radius_sq = config_.footprint_radius_m * config_.footprint_radius_m;
  const double lowest_way = footprint_.min.z(), highest_way = footprint_.max.z();
  for (int column = 0; column < kSide * kSide; ++column) {
    const Index3 first = geometry::voxel_at(block, column);
    const Vec3 offset = geometry::center_of(first, resolution_m()) - content_.vehicle_O;
    if (offset.head<2>().squaredNorm() > radius_sq) continue;
    const std::int32_t ground = there.ground()[static_cast<std::size_t>(column)];
    if (ground == TerrainColumn::kUnknown) continue;
    for (int z = 0; z < kSide; ++z) {
      const double height = (first.z + z + 0.5) * resolution_m();
      const bool is_low = heights_.low && first.z + z < ground + *heights_.low;
      if (is_low ? height >= lowest_way : height <= highest_way) {
        mask->reset(static_cast<std::size_t>(z) * kSide * kSide + static_cast<std::size_t>(column));
      }
    }
  }
}

/// Forbids voxels outside the limits of height, but for the way of a vehicle that is outside them itself.
bool NavigationView::forbid_heights(const Index3& block, BlockMask* hard) const {
  if (!heights_.low && !heights_.high) return false;
  const TerrainColumn* there = terrain().column(block.x, block.y);
  if (there == nullptr) return false;
  const geometry::Aabb box = box_of(block);
  const bool is_at_vehicle = (box.min.head<2>().array() <= footprint_.max.head<2>().array()).all() &&
                             (box.max.head<2>().array() >= footprint_.min.head<2>().array()).all();
  if (!is_at_vehicle) return there->forbid(block.z, heights_, hard);
  BlockMask outside;
  if (!there->forbid(block.z, heights_, &outside)) return false;
  allow_way_of_vehicle(block, *there, &outside);
  *hard |= outside;
  return outside.any();
}

bool NavigationView::forbid_obstacles(const Index3& block, BlockMask* mask) const {
  return content_.obstacles != nullptr && content_.obstacles->mask(block, mask);
}

std::shared_ptr<const planning::Fences> NavigationView::fences() const {
  return content_.fences != nullptr ? content_.fences->shared_fences() : nullptr;
}

bool NavigationView::forbidden(const Index3& block, BlockMask* hard, BlockMask* soft) const {
  const bool has_altitudes = forbid_altitudes(block, hard);
  const bool has_fences = content_.fences != nullptr && content_.fences->mask(block, hard);
  const bool has_obstacles = forbid_obstacles(block, config_.local_knows_better ? soft : hard);
  const bool has_heights = forbid_heights(block, hard);
  const bool has_things = content_.sightings != nullptr && content_.sightings->forbid(block, content_.vehicle_O, hard);
  return has_altitudes || has_fences || has_heights || has_obstacles || has_things;
}

const planning::Sightings* NavigationView::sightings() const {
  return content_.sightings != nullptr ? &content_.sightings->sightings() : nullptr;
}

}  // namespace voxnav::pipeline
