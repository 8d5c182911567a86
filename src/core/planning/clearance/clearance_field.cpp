// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/clearance_field.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "planning/clearance/clearance_field_impl.hpp"
#include "planning/clearance/field_update.hpp"
#include "planning/segment_box.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// Points beyond this many voxels from the origin exceed the range of a voxel's index.
constexpr double kMaxVoxels = 1e9;

}  // namespace

namespace {

/// How many voxels away the face of a voxel can be that lies within a radius.
int reach_of(double voxels) { return static_cast<int>(std::floor(std::min(voxels, 1e6) + 0.5 + 1e-9)); }

SquaredDistanceTransform transform_up_to(double voxels) {
  return SquaredDistanceTransform(reach_of(voxels), static_cast<int>(std::floor(4.0 * voxels * voxels + 1e-6)));
}

}  // namespace

std::vector<std::string> ClearanceFieldConfig::problems() const {
  std::vector<std::string> out;
  if (radius_m < safety_distance_m) out.emplace_back("radius_m must be at least safety_distance_m");
  return out;
}

std::vector<Index3> ClearanceField::Impl::candidates(const OccupancyView& view) const {
  std::vector<Index3> out = view.known_blocks();
  for (const auto& entry : blocks_.slots()) out.push_back(entry.first);
  return out;
}

ClearanceUpdate ClearanceField::Impl::update(const OccupancyView& view, const std::vector<Index3>& candidates) {
  const double resolution = view.resolution_m();
  if (!(resolution > 0.0) || reach_of(config_.safety_distance_m / resolution) > kMaxReach) {
    char text[160];
    std::snprintf(text, sizeof text, "safety_distance_m %.2f is more than %d voxels of %.3f m",
                  config_.safety_distance_m, kMaxReach, resolution);
    throw std::invalid_argument(text);
  }
  if (resolution != resolution_m_ || view.grown_by_m() != grown_by_m_) {
    *this = Impl(config_);
    resolution_m_ = resolution;
    grown_by_m_ = view.grown_by_m();
    occupied_transform_ = transform_up_to(radius_voxels());
    unknown_transform_ = transform_up_to(std::min(unknown_radius_m() / resolution, 1.0 * kMaxReach));
  }
  std::vector<Index3> sorted = candidates;
  std::sort(sorted.begin(), sorted.end());
  sorted.erase(std::unique(sorted.begin(), sorted.end()), sorted.end());
  try {
    return FieldUpdate(this, view).run(sorted);
  } catch (...) {
    // Half an update is no map to fly by.
    *this = Impl(config_);
    throw;
  }
}

void ClearanceField::Impl::label_components() {
  std::uint32_t num_parts = 1;
  for (std::int32_t slot = 0; slot < blocks_.end(); ++slot) {
    if (!blocks_.has(slot)) continue;
    blocks_.at(slot).first_part = num_parts;
    num_parts += static_cast<std::uint32_t>(blocks_.at(slot).parts.size());
  }
  std::vector<std::uint32_t>& parents = labels_;
  parents.resize(num_parts);
  std::iota(parents.begin(), parents.end(), 0u);
  const auto root_of = [&parents](std::uint32_t part) {
    while (parents[part] != part) part = parents[part] = parents[parents[part]];
    return part;
  };
  const auto unite = [&](std::uint32_t a, std::uint32_t b) {
    a = root_of(a);
    b = root_of(b);
    parents[std::max(a, b)] = std::min(a, b);
  };
  for (std::int32_t slot = 0; slot < blocks_.end(); ++slot) {
    if (!blocks_.has(slot)) continue;
    const ClearanceBlock& block = blocks_.at(slot);
    for (int axis = 0; axis < 3; ++axis) {
      if (block.contacts[axis].empty()) continue;
      const std::int32_t next = block.neighbours[neighbour_at(axis == 0, axis == 1, axis == 2)];
      const std::uint32_t first = blocks_.at(next).first_part;
      for (const auto& pair : block.contacts[axis]) unite(block.first_part + pair.first, first + pair.second);
    }
    for (const std::uint16_t part : block.outer_parts) unite(block.first_part + part, 0);
  }
  std::uint32_t num_labels = 0;
  for (std::uint32_t part = 0; part < num_parts; ++part) {
    parents[part] = parents[part] == part ? ++num_labels : parents[parents[part]];
  }
}

const ClearanceBlock* ClearanceField::Impl::block_of(const Index3& voxel) const {
  const std::int32_t slot = blocks_.find(geometry::block_of(voxel));
  return slot == ClearanceBlock::kNoSlot ? nullptr : &blocks_.at(slot);
}

VoxelState ClearanceField::Impl::state(const Index3& voxel) const {
  const ClearanceBlock* block = block_of(voxel);
  return block == nullptr ? VoxelState::kUnknown : block->states.get(geometry::offset_in_block(voxel));
}

std::uint32_t ClearanceField::Impl::component(const Index3& voxel) const {
  const ClearanceBlock* block = block_of(voxel);
  if (block == nullptr) {
    const bool is_flyable = config_.unknown_is_flyable && !labels_.empty() && bounds_.contains(voxel);
    return is_flyable ? labels_[0] : 0;
  }
  const int offset = geometry::offset_in_block(voxel);
  const BlockColumns& columns = config_.unknown_is_flyable ? block->passable : block->flyable;
  const int part = block->parts.part_of(columns, offset % kColumns, offset / kColumns);
  return part == FlyableParts::kNone ? 0 : labels_[block->first_part + static_cast<std::uint32_t>(part)];
}

std::size_t ClearanceField::Impl::memory_bytes() const {
  std::size_t out = sizeof(*this) + labels_.capacity() * sizeof(std::uint32_t);
  for (std::int32_t slot = 0; slot < blocks_.end(); ++slot) {
    if (!blocks_.has(slot)) continue;
    const ClearanceBlock& block = blocks_.at(slot);
    out += sizeof(ClearanceBlock) + 64 + block.parts.memory_bytes() - sizeof(FlyableParts);
    for (const auto& contacts : block.contacts) out += contacts.capacity() * sizeof(contacts.front());
    out += block.outer_parts.capacity() * sizeof(std::uint16_t);
    out += (block.to_occupied != nullptr ? sizeof(ClearanceDistances) : 0);
    out += (block.to_unknown != nullptr ? sizeof(ClearanceDistances) : 0);
  }
  return out;
}

ClearanceField::ClearanceField(const ClearanceFieldConfig& config)
    : impl_(std::make_unique<Impl>(base::checked(config))) {}
ClearanceField::~ClearanceField() = default;
ClearanceField::ClearanceField(ClearanceField&&) noexcept = default;
ClearanceField& ClearanceField::operator=(ClearanceField&&) noexcept = default;

ClearanceUpdate ClearanceField::update(const OccupancyView& view) {
  return impl_->update(view, impl_->candidates(view));
}

ClearanceUpdate ClearanceField::update(const OccupancyView& view, const std::vector<Index3>& changed_blocks) {
  return impl_->update(view, changed_blocks);
}

double ClearanceField::clearance(const Vec3& point) const {
  if (!point.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  const double radius = config().radius_m, resolution = resolution_m();
  if (resolution == 0.0 || (point.array().abs() > kMaxVoxels * resolution).any()) return radius;
  const Vec3 reach = Vec3::Constant(radius);
  const VoxelBox near{geometry::index_of(point - reach, resolution), geometry::index_of(point + reach, resolution)};
  double least = radius * radius;
  impl_->for_each_occupied(near, [&](const VoxelBox& run) {
    const geometry::Aabb box{Vec3(run.low.x, run.low.y, run.low.z) * resolution,
                             Vec3(run.high.x + 1, run.high.y + 1, run.high.z + 1) * resolution};
    least = std::min(least, squared_distance(point, box));
  });
  return std::sqrt(least);
}

std::uint32_t ClearanceField::component(const Vec3& point) const {
  if (!point.allFinite() || resolution_m() == 0.0) return 0;
  if ((point.array().abs() > kMaxVoxels * resolution_m()).any()) return 0;
  return impl_->component(geometry::index_of(point, resolution_m()));
}

int ClearanceField::squared_to_occupied(const Index3& voxel) const {
  const ClearanceBlock* block = impl_->block_of(voxel);
  if (block == nullptr || block->to_occupied == nullptr) return kFar;
  const int offset = geometry::offset_in_block(voxel);
  return (*block->to_occupied)[geometry::kBlockSide * (offset % kColumns) + offset / kColumns];
}

int ClearanceField::squared_to_unknown(const Index3& voxel) const {
  const ClearanceBlock* block = impl_->block_of(voxel);
  if (block == nullptr) return 0;
  if (block->to_unknown == nullptr) return kFar;
  const int offset = geometry::offset_in_block(voxel);
  return (*block->to_unknown)[geometry::kBlockSide * (offset % kColumns) + offset / kColumns];
}

const ClearanceFieldConfig& ClearanceField::config() const { return impl_->config(); }
double ClearanceField::resolution_m() const { return impl_->resolution_m(); }
std::size_t ClearanceField::num_blocks() const { return impl_->blocks().size(); }
std::size_t ClearanceField::memory_bytes() const { return impl_->memory_bytes(); }

}  // namespace voxnav::planning
