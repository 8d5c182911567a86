// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "odometry/point_map.hpp"

namespace voxnav::odometry {

VoxelKey key_of(const Vec3f& point, float inverse_size) {
  constexpr float kLimit = 1 << 20;
  VoxelKey key = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const float cell = std::floor(point[axis] * inverse_size);
    if (!(cell >= -kLimit && cell < kLimit)) return kNoKey;
    key = (key << 21) | static_cast<VoxelKey>(static_cast<std::int32_t>(cell) + (1 << 20));
  }
  return key;
}

VoxelTable::VoxelTable(std::size_t expected) {
  std::size_t capacity = 64;
  while (capacity < expected * 2) capacity *= 2;
  keys_.assign(capacity, kNoKey);
  values_.resize(capacity);
  mask_ = capacity - 1;
}

std::size_t VoxelTable::slot_of(VoxelKey key) const {
  // Finaliser of SplitMix64: neighbouring voxels must not share a run of slots.
  std::uint64_t h = key * 0x9E3779B97F4A7C15ull;
  h ^= h >> 29;
  return static_cast<std::size_t>(h) & mask_;
}

const std::uint32_t* VoxelTable::find(VoxelKey key) const {
  for (std::size_t slot = slot_of(key); keys_[slot] != kNoKey; slot = (slot + 1) & mask_) {
    if (keys_[slot] == key) return &values_[slot];
  }
  return nullptr;
}

bool VoxelTable::insert(VoxelKey key, std::uint32_t value) {
  std::size_t slot = slot_of(key);
  for (; keys_[slot] != kNoKey; slot = (slot + 1) & mask_) {
    if (keys_[slot] == key) return false;
  }
  keys_[slot] = key;
  values_[slot] = value;
  if (++size_ * 2 > keys_.size()) grow();
  return true;
}

void VoxelTable::clear() {
  std::fill(keys_.begin(), keys_.end(), kNoKey);
  size_ = 0;
}

void VoxelTable::grow() {
  VoxelTable larger(keys_.size());
  for (std::size_t i = 0; i < keys_.size(); ++i) {
    if (keys_[i] != kNoKey) larger.insert(keys_[i], values_[i]);
  }
  *this = std::move(larger);
}

void downsample(const std::vector<Vec3f>& points, double voxel_size_m, VoxelTable* scratch, std::vector<Vec3f>* out) {
  scratch->clear();
  out->clear();
  const float inverse_size = static_cast<float>(1.0 / voxel_size_m);
  for (const Vec3f& p : points) {
    const VoxelKey key = key_of(p, inverse_size);
    if (key != kNoKey && scratch->insert(key, 0)) out->push_back(p);
  }
}

}  // namespace voxnav::odometry
