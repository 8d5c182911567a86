// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/surface_leaves.hpp"

#include <algorithm>
#include <cmath>

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

void SurfaceLeaf::add_scan(const geometry::Vec3f& offset) {
  if (scans < 255) ++scans;
  const float share = 1.0f / static_cast<float>(std::min<int>(scans, kMemory));
  for (int axis = 0; axis < 3; ++axis) {
    const float target = std::clamp(offset[axis], -0.5f, 0.5f) * (2.0f * kMeanUnits);
    const float moved = static_cast<float>(mean[axis]) + (target - static_cast<float>(mean[axis])) * share;
    mean[axis] = static_cast<std::int16_t>(std::lrint(moved));
  }
  octants = 0;
}

OccupiedLeaf SurfaceLeaf::quantised(int offset_in_block) const {
  OccupiedLeaf leaf;
  leaf.offset = static_cast<std::uint16_t>(offset_in_block);
  for (int axis = 0; axis < 3; ++axis) {
    leaf.mean[axis] = static_cast<std::int8_t>(std::lrint(static_cast<float>(mean[axis]) * (127.0f / kMeanUnits)));
  }
  leaf.hits = scans;
  return leaf;
}

void SurfaceLeaves::assign(const VoxelBits& bits) {
  if (bits == bits_) return;
  std::vector<SurfaceLeaf> packed;
  std::array<std::uint16_t, 64> first{};
  std::size_t count = 0;
  for (int word = 0; word < 64; ++word) {
    first[word] = static_cast<std::uint16_t>(count);
    count += static_cast<std::size_t>(__builtin_popcountll(bits[word]));
  }
  packed.reserve(count);
  for (int word = 0; word < 64; ++word) {
    for_each_bit(bits[word], [&](int bit) {
      const SurfaceLeaf* old = find(word * 64 + bit);
      packed.push_back(old ? *old : SurfaceLeaf{});
    });
  }
  leaves_ = std::move(packed);
  first_ = first;
  bits_ = bits;
}

}  // namespace voxnav::occupancy
