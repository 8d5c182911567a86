// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/ray_marker.hpp"

#include <cmath>
#include <cstdlib>
#include <limits>

namespace voxnav::occupancy {

/// One ray, from its end back to the sensor.
struct RayMarker::Walk {
  geometry::Vec3f end;
  geometry::Vec3f direction;  ///< unit, towards the sensor
  bool is_evidence;           ///< counts against surfaces
};

RayMarker::RayMarker(std::array<int, 3> num_blocks) : num_blocks_(num_blocks) {
  index_.assign(static_cast<std::size_t>(num_blocks[0]) * num_blocks[1] * num_blocks[2], -1);
}

void RayMarker::begin(const BlockWindow& window, const EndVoxels& ends, const MissGuard& guard,
                      const geometry::Vec3& origin) {
  for (const BlockMarks& block : blocks_) index_[block.slot] = -1;
  blocks_.clear();
  crossings_.clear();
  window_ = &window;
  ends_ = &ends;
  guard_ = guard;
  origin_ = origin.cast<float>();
}

RayMarker::BlockMarks& RayMarker::touch(std::uint32_t slot) {
  if (index_[slot] >= 0) return blocks_[index_[slot]];
  index_[slot] = static_cast<std::int32_t>(blocks_.size());
  blocks_.emplace_back();
  BlockMarks& marks = blocks_.back();
  marks.slot = slot;
  const OctreeBlock* block = window_->at(static_cast<int>(slot));
  const VoxelBits* hits = ends_->hit_bits(slot);
  if (block == nullptr || block->leaves.empty()) return marks;
  for (int i = 0; i < 64; ++i) marks.rows[i].surface = block->leaves.bits()[i] & ~(hits ? (*hits)[i] : 0);
  return marks;
}

void RayMarker::cross_surface(std::uint32_t slot, int offset, const Walk& walk) {
  const geometry::Vec3f center = ends_->center_of({slot, static_cast<std::uint16_t>(offset), {}});
  const geometry::Vec3f mean = center + window_->at(static_cast<int>(slot))->leaves.find(offset)->offset();
  const geometry::Vec3f to_mean = mean - walk.end;
  const float along = to_mean.dot(walk.direction);
  if (along < guard_.end_voxels) return;
  const float distance_squared = to_mean.squaredNorm() - along * along;
  std::uint8_t octants = 0xFF;
  if (distance_squared > guard_.distance_voxels * guard_.distance_voxels) {
    const float nearest = (center - walk.end).dot(walk.direction);
    const geometry::Vec3f at = walk.end + nearest * walk.direction - center;
    octants = static_cast<std::uint8_t>(1u << ((at.x() > 0.0f ? 1 : 0) | (at.y() > 0.0f ? 2 : 0) | (at.z() > 0.0f ? 4 : 0)));
  }
  crossings_.push_back({slot, static_cast<std::uint16_t>(offset), octants});
}

inline void RayMarker::mark(BlockMarks& block, int offset, const Walk& walk) {
  Row& row = block.rows[offset >> 6];
  const std::uint64_t bit = std::uint64_t{1} << (offset & 63);
  row.passed |= bit;
  if ((row.surface & bit) != 0 && walk.is_evidence) cross_surface(block.slot, offset, walk);
}

void RayMarker::cast(const geometry::Vec3f& end, Ray kind) {
  const geometry::Vec3f delta = origin_ - end;
  const Walk walk{end, delta.normalized(), kind != Ray::kNoReturn};
  const int slot_step[3] = {1, num_blocks_[0], num_blocks_[0] * num_blocks_[1]};
  float next[3];   // ray parameter (0 end, 1 origin) at which the next voxel is entered on each axis
  float pitch[3];  // parameter per voxel
  int cell[3];
  int step[3];      // change of the offset in the block
  int limit[3];     // coordinate bits from which the step leaves the block
  int to_slot[3];   // change of the slot when it does
  int steps = 0;
  for (int axis = 0; axis < 3; ++axis) {
    cell[axis] = static_cast<int>(end[axis]);
    steps += std::abs(static_cast<int>(origin_[axis]) - cell[axis]);
    const bool forward = delta[axis] > 0.0f;
    const int mask = 15 << (4 * axis);
    step[axis] = forward ? 1 << (4 * axis) : -(1 << (4 * axis));
    limit[axis] = forward ? mask : 0;
    to_slot[axis] = forward ? slot_step[axis] : -slot_step[axis];
    const float length = std::abs(delta[axis]);
    pitch[axis] = length > 0.0f ? 1.0f / length : std::numeric_limits<float>::infinity();
    const float room = forward ? static_cast<float>(cell[axis] + 1) - end[axis] : end[axis] - static_cast<float>(cell[axis]);
    next[axis] = length > 0.0f ? room * pitch[axis] : std::numeric_limits<float>::infinity();
  }
  auto slot = static_cast<std::uint32_t>((cell[0] >> 4) + slot_step[1] * (cell[1] >> 4) + slot_step[2] * (cell[2] >> 4));
  int offset = geometry::offset_in_block({cell[0], cell[1], cell[2]});
  BlockMarks* block = &touch(slot);
  if (kind != Ray::kHit) mark(*block, offset, walk);
  // The number of steps is exact, so the walk cannot run past the origin, whatever the rounding.
  for (; steps > 0; --steps) {
    const int low = next[1] < next[0] ? 1 : 0;
    const int axis = next[2] < next[low] ? 2 : low;
    next[axis] += pitch[axis];
    const int mask = 15 << (4 * axis);
    if ((offset & mask) == limit[axis]) {
      offset ^= mask;
      slot += static_cast<std::uint32_t>(to_slot[axis]);
      block = &touch(slot);
    } else {
      offset += step[axis];
    }
    mark(*block, offset, walk);
  }
}

void RayMarker::merge(const RayMarker& other) {
  for (const BlockMarks& from : other.blocks_) {
    BlockMarks& to = touch(from.slot);
    for (int i = 0; i < 64; ++i) to.rows[i].passed |= from.rows[i].passed;
  }
  crossings_.insert(crossings_.end(), other.crossings_.begin(), other.crossings_.end());
}

std::size_t RayMarker::memory_bytes() const {
  return index_.capacity() * sizeof(index_[0]) + blocks_.capacity() * sizeof(BlockMarks) +
         crossings_.capacity() * sizeof(Crossing);
}

}  // namespace voxnav::occupancy
