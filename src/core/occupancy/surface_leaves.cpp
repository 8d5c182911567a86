// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/surface_leaves.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

namespace voxnav::occupancy {

namespace {

/// Rounds halves away from zero. std::lrint() would be a function call, as the build does not set -fno-math-errno.
std::int16_t rounded(float value) { return static_cast<std::int16_t>(value + std::copysign(0.5f, value)); }

// kernels::StoredMoments reads and writes whole vector registers: the two means must lie together as six numbers, and
// at least 16 bytes must be readable from the first number of the means and of the covariance on.
static_assert(offsetof(SurfaceLeaf, mean) + sizeof(SurfaceLeaf::mean) == offsetof(SurfaceLeaf, recent_mean));
static_assert(offsetof(SurfaceLeaf, covariance) + 16 <= sizeof(SurfaceLeaf));
static_assert(offsetof(SurfaceLeaf, mean) + 16 <= sizeof(SurfaceLeaf));

}  // namespace

void SurfaceLeaf::add_scan(const PointSpread& hits, int number) {
  if (scans < 255) ++scans;
  if (recent_scans < 65535) ++recent_scans;
  const float share = 1.0f / static_cast<float>(std::min<int>(scans, kMemory));
  const float recent_share = 1.0f / static_cast<float>(recent_scans);
  const float later = static_cast<float>(kTimeUnits * number) - static_cast<float>(recent_time);
  const float time = static_cast<float>(recent_time) + recent_share * later + 0.5f;  // rounded by the conversion
  recent_time = static_cast<std::uint16_t>(time);
  const auto hit = [&](int axis) { return std::min(std::max(hits.mean[axis], -0.5f), 0.5f); };
  kernels::blend_moments({{hit(0), hit(1), hit(2)}, hits.covariance, share, recent_share},
                         {covariance.data(), mean.data()});
  patience = std::max(patience, seen_through);
  seen_through = 0;
  octants = 0;
}

bool SurfaceLeaf::is_refuted_by_seeing_through(int max_patience) {
  if (seen_through < 255) ++seen_through;
  return seen_through > std::min<int>(patience, max_patience);
}

OccupiedVoxel SurfaceLeaf::quantised(int offset_in_block, int num_scans) const {
  const auto in_bytes = [](std::int16_t value) {
    return static_cast<std::int8_t>(rounded(static_cast<float>(value) * (127.0f / kMeanUnits)));
  };
  OccupiedVoxel voxel;
  voxel.offset = static_cast<std::uint16_t>(offset_in_block);
  for (int axis = 0; axis < 3; ++axis) {
    voxel.believed.mean[axis] = in_bytes(mean[axis]);
    voxel.observed.mean[axis] = in_bytes(recent_mean[axis]);
  }
  voxel.believed.hits = scans;
  voxel.observed.hits = static_cast<std::uint8_t>(std::min<int>(recent_scans, 255));
  if (recent_scans > 0 && num_scans > 0) {
    const float share = (static_cast<float>(recent_time) / kTimeUnits - 0.5f) / static_cast<float>(num_scans);
    const float time = std::clamp(share, 0.0f, 1.0f) * 255.0f + 0.5f;  // rounded by the conversion
    voxel.observed_time = static_cast<std::uint8_t>(time);
  }
  return voxel;
}

void SurfaceLeaves::begin_handover() {
  for (SurfaceLeaf& leaf : leaves_) {
    leaf.recent_mean = {};
    leaf.recent_scans = 0;
    leaf.recent_time = 0;
  }
}

void SurfaceLeaves::assign(const VoxelBits& bits) {
  if (bits == bits_) return;
  std::array<std::uint16_t, 64> first{};
  std::size_t count = 0;
  for (int word = 0; word < 64; ++word) {
    first[word] = static_cast<std::uint16_t>(count);
    count += kernels::count_bits(bits[word]);
  }
  std::vector<SurfaceLeaf> packed(count);
  for (int word = 0; word < 64; ++word) {
    const SurfaceLeaf* old = leaves_.data() + first_[word];
    SurfaceLeaf* next = packed.data() + first[word];
    kernels::for_each_bit(bits[word] | bits_[word], [&](int bit) {
      const bool was = ((bits_[word] >> bit) & 1u) != 0, is = ((bits[word] >> bit) & 1u) != 0;
      if (was && is) *next = *old;
      old += was ? 1 : 0;
      next += is ? 1 : 0;
    });
  }
  leaves_ = std::move(packed);
  first_ = first;
  bits_ = bits;
}

}  // namespace voxnav::occupancy
