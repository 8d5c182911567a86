// SPDX-License-Identifier: BSD-3-Clause
#include "planning/clearance/field_update.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <stdexcept>

namespace voxnav::planning {
namespace {

using geometry::Index3;

constexpr int kSide = geometry::kBlockSide;

bool is_blank(const ClearanceBlock& block) {
  return !block.has_hard && !block.has_soft && block.to_occupied == nullptr && block.states.all_unknown();
}

/// The voxels of a block outside its part within the bounds.
BlockColumns outside(const VoxelBox& inside) {
  BlockColumns out;
  out.fill(kWholeColumn);
  if (inside.high.x < 0) return out;
  const auto heights = static_cast<std::uint16_t>(((2u << inside.high.z) - 1u) & ~((1u << inside.low.z) - 1u));
  for (int y = inside.low.y; y <= inside.high.y; ++y) {
    for (int x = inside.low.x; x <= inside.high.x; ++x) out[column_at(x, y)] = static_cast<std::uint16_t>(~heights);
  }
  return out;
}

/// The voxels of a column nearer than a squared distance.
std::uint16_t nearer_than(const ClearanceDistances* distances, int column, double squared) {
  if (distances == nullptr) return 0;
  const std::int16_t* at = &(*distances)[static_cast<std::size_t>(column) * kSide];
  std::uint32_t out = 0;
  for (int z = 0; z < kSide; ++z) out |= static_cast<std::uint32_t>(at[z] < squared) << z;
  return static_cast<std::uint16_t>(out);
}

bool is_any(const BlockColumns& columns) {
  return std::any_of(columns.begin(), columns.end(), [](std::uint16_t bits) { return bits != 0; });
}

bool is_all_far(const ClearanceDistances& distances) {
  return std::all_of(distances.begin(), distances.end(), [](int d) { return d == ClearanceField::kFar; });
}

}  // namespace

ClearanceUpdate FieldUpdate::run(const std::vector<Index3>& candidates) {
  read_bounds();
  field_.fences_ = view_.fences();
  for (const Index3& index : candidates) read_block(index);
  std::set<Index3> touched;
  for (const auto& [index, work] : work_) {
    if (recompute(index, work)) touched.insert(index);
  }
  for (const auto& [index, work] : work_) {
    if (drop_if_blank(index)) touched.insert(index);
  }
  if (!touched.empty() || has_new_bounds_) label_again(touched);
  return result_;
}

void FieldUpdate::label_again(const std::set<Index3>& touched) {
  // What meets a block that has changed, appeared or vanished, meets other parts now.
  std::set<Index3> meeting = touched;
  for (const Index3& index : touched) {
    for (const Index3& step : {Index3{1, 0, 0}, Index3{0, 1, 0}, Index3{0, 0, 1}}) {
      meeting.insert(index + step);
      meeting.insert(index - step);
    }
  }
  for (std::int32_t slot = 0; slot < field_.blocks_.end(); ++slot) {
    if (!field_.blocks_.has(slot)) continue;
    if (has_new_bounds_ || meeting.count(field_.blocks_.at(slot).index) > 0) meet_neighbours(slot);
  }
  field_.label_components();
}

void FieldUpdate::read_bounds() {
  const VoxelBox bounds = voxels_in(view_.bounds(), view_.resolution_m());
  const VoxelBox old_bounds = field_.bounds_;
  has_new_bounds_ = bounds != old_bounds;
  field_.bounds_ = bounds;
  if (!has_new_bounds_) return;
  for (std::int32_t slot = 0; slot < field_.blocks_.end(); ++slot) {
    if (!field_.blocks_.has(slot)) continue;
    const ClearanceBlock& block = field_.blocks_.at(slot);
    if (part_in(bounds, block.index) != block.inside) work_[block.index].flyable = ColumnRange::whole();
  }
  insert_near_obstacles(old_bounds);
}

/// Blocks that lie within the bounds only now get the distances to obstacles that were there before.
void FieldUpdate::insert_near_obstacles(const VoxelBox& old_bounds) {
  std::set<Index3> missing;
  for (std::int32_t slot = 0; slot < field_.blocks_.end(); ++slot) {
    if (!field_.blocks_.has(slot) || !is_any(field_.blocks_.at(slot).occupied)) continue;
    const ClearanceBlock& block = field_.blocks_.at(slot);
    for (int i = 0; i < 27; ++i) {
      if (block.neighbours[i] != ClearanceBlock::kNoSlot) continue;
      const Index3 other = block.index + Index3{i % 3 - 1, i / 3 % 3 - 1, i / 9 - 1};
      const bool was_inside = part_in(old_bounds, other) != VoxelBox{};
      if (!was_inside && part_in(field_.bounds_, other) != VoxelBox{}) missing.insert(other);
    }
  }
  for (const Index3& index : missing) insert(index);
}

void FieldUpdate::read_block(const Index3& index) {
  static const StateBlock kUnknown{};
  StateBlock scratch;
  const StateBlock* found = view_.block(index, &scratch);
  const StateBlock& states = found != nullptr ? *found : kUnknown;
  BlockColumns hard{}, soft{};
  const bool is_forbidden = read_forbidden(index, &hard, &soft);
  std::int32_t slot = field_.blocks_.find(index);
  if (slot == ClearanceBlock::kNoSlot) {
    if (!is_forbidden && states.all_unknown()) return;
    slot = insert(index);
  }
  ClearanceBlock& block = field_.blocks_.at(slot);
  const bool has_new_limits = block.hard != hard || block.soft != soft;
  const bool has_new_states = block.states.words != states.words;
  if (has_new_limits) forbid(&block, hard, soft);
  if (has_new_states) {
    block.states = states;
    const BlockColumns occupied = block.occupied, unknown = block.unknown;
    columns_of(states, &block.occupied, &block.unknown);
    block.occupied_rows = rows_of(block.occupied);
    spread(index, change_of(occupied, block.occupied), &Work::to_occupied);
    spread(index, change_of(unknown, block.unknown), &Work::to_unknown);
  }
  result_.changed_blocks += has_new_limits || has_new_states ? 1 : 0;
}

bool FieldUpdate::read_forbidden(const Index3& index, BlockColumns* hard, BlockColumns* soft) const {
  BlockMask hard_mask, soft_mask;
  if (!view_.forbidden(index, &hard_mask, &soft_mask)) return false;
  *hard = columns_of(hard_mask);
  *soft = columns_of(soft_mask);
  return true;
}

void FieldUpdate::forbid(ClearanceBlock* block, const BlockColumns& hard, const BlockColumns& soft) {
  block->hard = hard;
  block->soft = soft;
  block->has_hard = is_any(hard);
  block->has_soft = is_any(soft);
  work_[block->index].flyable = ColumnRange::whole();
}

std::int32_t FieldUpdate::insert(const Index3& index) {
  check_memory();
  Work& work = work_[index];
  work.to_occupied = work.to_unknown = work.flyable = ColumnRange::whole();
  const std::int32_t slot = field_.blocks_.insert(index);
  BlockColumns hard{}, soft{};
  if (read_forbidden(index, &hard, &soft)) forbid(&field_.blocks_.at(slot), hard, soft);
  return slot;
}

FieldUpdate::Change FieldUpdate::change_of(const BlockColumns& before, const BlockColumns& after) {
  Change out;
  std::uint32_t heights = 0;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      const std::uint32_t bits = before[column_at(x, y)] ^ after[column_at(x, y)];
      if (bits == 0) continue;
      heights |= bits;
      out.columns.extend({x, y, x + 1, y + 1});
    }
  }
  if (heights == 0) return out;
  out.low = __builtin_ctz(heights);
  out.high = 31 - __builtin_clz(heights);
  return out;
}

void FieldUpdate::spread(const Index3& index, const Change& change, ColumnRange Work::*kind) {
  if (change.columns.empty()) return;
  const int reach = (kind == &Work::to_unknown ? field_.unknown_transform_ : field_.occupied_transform_)->reach();
  for (int dz = -1; dz <= 1; ++dz) {
    if ((dz < 0 && change.low >= reach) || (dz > 0 && change.high < kSide - reach)) continue;
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        const ColumnRange range = change.columns.reach(reach, dx, dy);
        if (range.empty()) continue;
        const Index3 other = index + Index3{dx, dy, dz};
        if (field_.blocks_.find(other) == ClearanceBlock::kNoSlot) {
          // An unknown block near an obstacle is kept for its distances; unknown near unknown is nothing new.
          if (kind == &Work::to_unknown || part_in(field_.bounds_, other) == VoxelBox{}) continue;
          insert(other);
        }
        (work_[other].*kind).extend(range);
      }
    }
  }
  // Whether a voxel may be entered depends on its own state as well, whatever the radius is.
  work_[index].flyable.extend(change.columns);
}

void FieldUpdate::check_memory() const {
  const std::size_t needed = (field_.blocks_.size() + 1) * ClearanceBlock::max_bytes();
  if (static_cast<double>(needed) <= field_.config_.max_memory_mib * 1048576.0) return;
  char text[160];
  std::snprintf(text, sizeof text, "the clearance field needs more than the %.1f MiB that max_memory_mib allows",
                field_.config_.max_memory_mib);
  throw std::length_error(text);
}

bool FieldUpdate::recompute(const Index3& index, const Work& work) {
  ClearanceBlock& block = field_.blocks_.at(field_.blocks_.find(index));
  ++result_.recomputed_blocks;
  recompute_distances(&block, work);
  ColumnRange range = work.flyable;
  range.extend(work.to_occupied);
  if (block.has_soft) range.extend(work.to_unknown);
  return !range.empty() && recompute_flyable(&block, range);
}

void FieldUpdate::recompute_distances(ClearanceBlock* block, const Work& work) {
  const auto recompute_kind = [&](const ColumnRange& range, bool is_unknown, std::unique_ptr<ClearanceDistances>* out) {
    if (range.empty()) return;
    SurroundingColumns set;
    set.absent_is_set = is_unknown;
    for (std::size_t i = 0; i < set.blocks.size(); ++i) {
      const std::int32_t slot = block->neighbours[i];
      if (slot == ClearanceBlock::kNoSlot) continue;
      const ClearanceBlock& other = field_.blocks_.at(slot);
      set.blocks[i] = is_unknown ? &other.unknown : &other.occupied;
    }
    if (*out == nullptr) {
      *out = std::make_unique<ClearanceDistances>();
      (*out)->fill(ClearanceField::kFar);
    }
    SquaredDistanceTransform& transform = is_unknown ? *field_.unknown_transform_ : *field_.occupied_transform_;
    const bool is_any_near = transform.compute(set, range, out->get());
    if (!is_any_near && is_all_far(**out)) out->reset();
  };
  recompute_kind(work.to_occupied, false, &block->to_occupied);
  recompute_kind(work.to_unknown, true, &block->to_unknown);
}

bool FieldUpdate::recompute_flyable(ClearanceBlock* block, const ColumnRange& range) {
  block->inside = part_in(field_.bounds_, block->index);
  const BlockColumns beyond = outside(block->inside);
  const BlockColumns passable = block->passable, flyable = block->flyable;
  const double distance = field_.clearance_m() / field_.resolution_m();
  // Rounding must not turn a voxel at exactly the safety distance into an obstacle.
  const double squared = 4.0 * distance * distance - 4e-4;
  for (int y = range.y0; y < range.y1; ++y) {
    for (int x = range.x0; x < range.x1; ++x) {
      const int column = column_at(x, y);
      std::uint32_t closed = block->occupied[column] | block->hard[column] | beyond[column];
      closed |= nearer_than(block->to_occupied.get(), column, squared);
      if (block->soft[column] != 0) {
        const auto blind = nearer_than(block->to_unknown.get(), column, std::max(squared, 0.5));
        closed |= block->soft[column] & blind;
      }
      block->passable[column] = static_cast<std::uint16_t>(~closed);
      block->flyable[column] =
          static_cast<std::uint16_t>(~closed & ~static_cast<std::uint32_t>(block->unknown[column]));
    }
  }
  if (passable == block->passable && flyable == block->flyable) return false;
  block->parts.assign(field_.config_.unknown_is_flyable ? block->passable : block->flyable);
  return true;
}

bool FieldUpdate::drop_if_blank(const Index3& index) {
  const std::int32_t slot = field_.blocks_.find(index);
  if (slot == ClearanceBlock::kNoSlot || !is_blank(field_.blocks_.at(slot))) return false;
  field_.blocks_.remove(slot);
  return true;
}

void FieldUpdate::meet_neighbours(std::int32_t slot) {
  ClearanceBlock& block = field_.blocks_.at(slot);
  const bool is_through_unknown = field_.config_.unknown_is_flyable;
  const auto side_of = [is_through_unknown](const ClearanceBlock& b) {
    return FlyableParts::Side{is_through_unknown ? &b.passable : &b.flyable, &b.parts};
  };
  block.outer_parts.clear();
  for (int face = 0; face < 6; ++face) {
    const int axis = face / 2, step = face % 2 == 0 ? -1 : 1;
    const Index3 offset{axis == 0 ? step : 0, axis == 1 ? step : 0, axis == 2 ? step : 0};
    const std::int32_t other = block.neighbours[neighbour_at(offset.x, offset.y, offset.z)];
    if (step > 0) block.contacts[axis].clear();
    if (other != ClearanceBlock::kNoSlot) {
      if (step > 0) {
        block.contacts[axis] = FlyableParts::contacts(side_of(block), side_of(field_.blocks_.at(other)), axis);
      }
    } else if (is_through_unknown && part_in(field_.bounds_, block.index + offset) != VoxelBox{}) {
      const auto outer = block.parts.parts_at_face(*side_of(block).flyable, face);
      block.outer_parts.insert(block.outer_parts.end(), outer.begin(), outer.end());
    }
  }
}

}  // namespace voxnav::planning
