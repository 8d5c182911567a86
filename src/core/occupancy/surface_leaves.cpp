// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/surface_leaves.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstring>

#include "base/lanes.hpp"
#include "occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

namespace {

using namespace base::lanes;  // NOLINT: the vector types of this file

/// std::lrint() is a call without -fno-math-errno; halves away from zero.
std::int16_t rounded(float value) { return static_cast<std::int16_t>(value + std::copysign(0.5f, value)); }
VOXNAV_INLINE Ints rounded(Floats value) {
  return truncated(value + (value < 0.0f ? Floats{} - 0.5f : Floats{} + 0.5f));
}
VOXNAV_INLINE Floats clamped(Floats value, float limit) {
  return smaller(larger(value, Floats{} - limit), Floats{} + limit);
}

constexpr float kCovarianceUnit = 1.0f / SurfaceLeaf::kCovarianceUnits;  // divisions are slow

using Shorts = std::int16_t __attribute__((vector_size(16)));

/// Eight of a leaf's numbers from `at` on, of which those that do not belong together are ignored.
VOXNAV_INLINE Floats loaded_from(const SurfaceLeaf& leaf, std::size_t at) {
  Shorts out;
  std::memcpy(&out, reinterpret_cast<const char*>(&leaf) + at, sizeof out);
  return floats(__builtin_convertvector(out, Ints));
}
/// Six of them back.
VOXNAV_INLINE void store_six(Floats values, SurfaceLeaf* leaf, std::size_t at) {
  const Shorts out = __builtin_convertvector(rounded(values), Shorts);
  std::memcpy(reinterpret_cast<char*>(leaf) + at, &out, 6 * sizeof(std::int16_t));
}
constexpr std::size_t kCovarianceAt = offsetof(SurfaceLeaf, covariance);
constexpr std::size_t kMeansAt = offsetof(SurfaceLeaf, mean);
static_assert(kMeansAt + sizeof(SurfaceLeaf::mean) == offsetof(SurfaceLeaf, recent_mean), "read together");

}  // namespace

VOXNAV_INLINE void SurfaceLeaf::add(const PointSpread& hits, int number) {
  if (scans < 255) ++scans;
  if (recent_scans < 65535) ++recent_scans;
  const float share = 1.0f / static_cast<float>(std::min<int>(scans, kMemory));
  const float recent_share = 1.0f / static_cast<float>(recent_scans);
  const float later = static_cast<float>(kTimeUnits * number) - static_cast<float>(recent_time);
  recent_time = static_cast<std::uint16_t>(static_cast<float>(recent_time) + recent_share * later + 0.5f);
  const auto hit = [&](int axis) { return std::min(std::max(hits.mean[axis], -0.5f), 0.5f); };
  const float x = hit(0), y = hit(1), z = hit(2);
  const auto moved = [&](float to, int axis) { return to - static_cast<float>(mean[axis]) * (0.5f / kMeanUnits); };
  const float dx = moved(x, 0), dy = moved(y, 1), dz = moved(z, 2);
  const Floats means = loaded_from(*this, kMeansAt);
  const Floats shares{share, share, share, recent_share, recent_share, recent_share, 0.0f, 0.0f};
  store_six(means + shares * (Floats{x, y, z, x, y, z, 0.0f, 0.0f} * (2.0f * kMeanUnits) - means), this, kMeansAt);
  // Covariance of a mixture of two sets of points.
  const auto& c = hits.covariance;
  const Floats products{dx * dx, dx * dy, dx * dz, dy * dy, dy * dz, dz * dz, 0.0f, 0.0f};
  const Floats mixed = (1.0f - share) * (loaded_from(*this, kCovarianceAt) * kCovarianceUnit + share * products) +
                       share * Floats{c[0], c[1], c[2], c[3], c[4], c[5], 0.0f, 0.0f};
  store_six(clamped(mixed, 0.25f) * kCovarianceUnits, this, kCovarianceAt);
  patience = std::max(patience, seen_through);
  seen_through = 0;
  octants = 0;
}

void SurfaceLeaf::add_plain(const PointSpread& hits, int number) { add(hits, number); }
VOXNAV_WIDE void SurfaceLeaf::add_wide(const PointSpread& hits, int number) { add(hits, number); }

void SurfaceLeaf::add_scan(const PointSpread& hits, int number) {
  base::is_wide() ? add_wide(hits, number) : add_plain(hits, number);
}

bool SurfaceLeaf::is_refuted_by_seeing_through(int max_patience) {
  if (seen_through < 255) ++seen_through;
  return seen_through > std::min<int>(patience, max_patience);
}

OccupiedLeaf SurfaceLeaf::quantised(int offset_in_block, int num_scans) const {
  const auto in_bytes = [](std::int16_t value) {
    return static_cast<std::int8_t>(rounded(static_cast<float>(value) * (127.0f / kMeanUnits)));
  };
  OccupiedLeaf leaf;
  leaf.offset = static_cast<std::uint16_t>(offset_in_block);
  for (int axis = 0; axis < 3; ++axis) {
    leaf.mean[axis] = in_bytes(mean[axis]);
    leaf.own_mean[axis] = in_bytes(recent_mean[axis]);
  }
  leaf.hits = scans;
  leaf.own_hits = static_cast<std::uint8_t>(std::min<int>(recent_scans, 255));
  if (recent_scans > 0 && num_scans > 0) {
    const float share = (static_cast<float>(recent_time) / kTimeUnits - 0.5f) / static_cast<float>(num_scans);
    leaf.own_time = static_cast<std::uint8_t>(std::clamp(share, 0.0f, 1.0f) * 255.0f + 0.5f);
  }
  return leaf;
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
    count += count_bits(bits[word]);
  }
  std::vector<SurfaceLeaf> packed(count);
  for (int word = 0; word < 64; ++word) {
    const SurfaceLeaf* old = leaves_.data() + first_[word];
    SurfaceLeaf* next = packed.data() + first[word];
    for_each_bit(bits[word] | bits_[word], [&](int bit) {
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
