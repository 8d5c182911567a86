// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/surface_leaves.hpp"

#include <algorithm>
#include <cmath>

#include "voxnav/occupancy/byte_ops.hpp"

namespace voxnav::occupancy {

namespace {

/// std::lrint() is a call without -fno-math-errno; halves away from zero.
std::int16_t rounded(float value) { return static_cast<std::int16_t>(value + std::copysign(0.5f, value)); }

constexpr float kCovarianceUnit = 1.0f / SurfaceLeaf::kCovarianceUnits;  // divisions are slow

}  // namespace

void SurfaceLeaf::add_scan(const PointSpread& hits, int number) {
  if (scans < 255) ++scans;
  if (recent_scans < 65535) ++recent_scans;
  const float share = 1.0f / static_cast<float>(std::min<int>(scans, kMemory));
  const float recent_share = 1.0f / static_cast<float>(recent_scans);
  const float later = static_cast<float>(kTimeUnits * number) - static_cast<float>(recent_time);
  recent_time = static_cast<std::uint16_t>(static_cast<float>(recent_time) + recent_share * later + 0.5f);
  geometry::Vec3f moved;
  for (int axis = 0; axis < 3; ++axis) {
    const float old = static_cast<float>(mean[axis]) * (0.5f / kMeanUnits);
    const float hit = std::clamp(hits.mean[axis], -0.5f, 0.5f);
    moved[axis] = hit - old;
    mean[axis] = rounded((old + share * moved[axis]) * (2.0f * kMeanUnits));
    const float recent = static_cast<float>(recent_mean[axis]);
    recent_mean[axis] = rounded(recent + recent_share * (hit * (2.0f * kMeanUnits) - recent));
  }
  int i = 0;
  for (int row = 0; row < 3; ++row) {
    for (int column = row; column < 3; ++column, ++i) {
      // Covariance of a mixture of two sets of points.
      const float old = static_cast<float>(covariance[i]) * kCovarianceUnit;
      const float mixed = (1.0f - share) * (old + share * moved[row] * moved[column]) + share * hits.covariance[i];
      covariance[i] = rounded(std::clamp(mixed, -0.25f, 0.25f) * kCovarianceUnits);
    }
  }
  patience = std::max(patience, seen_through);
  seen_through = 0;
  octants = 0;
}

bool SurfaceLeaf::is_refuted_by_seeing_through(int max_patience) {
  if (seen_through < 255) ++seen_through;
  return seen_through > std::min<int>(patience, max_patience);
}

float SurfaceLeaf::squared_distance(const geometry::Vec3f& to_mean, const geometry::Vec3f& direction,
                                    float least_spread) const {
  const auto entry = [&](int i) { return static_cast<float>(covariance[i]) * kCovarianceUnit; };
  const float least = least_spread * least_spread;
  const float xx = entry(0) + least, xy = entry(1), xz = entry(2);
  const float yy = entry(3) + least, yz = entry(4), zz = entry(5) + least;
  // Adjugate: the inverse times the determinant.
  Eigen::Matrix3f adjugate;
  adjugate << yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy,  //
      xz * yz - xy * zz, xx * zz - xz * xz, xy * xz - xx * yz,          //
      xy * yz - xz * yy, xy * xz - xx * yz, xx * yy - xy * xy;
  const float determinant = xx * adjugate(0, 0) + xy * adjugate(1, 0) + xz * adjugate(2, 0);
  const geometry::Vec3f weighted = adjugate * direction;
  const float along = to_mean.dot(weighted);
  return (to_mean.dot(adjugate * to_mean) - along * along / direction.dot(weighted)) / determinant;
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
  std::vector<SurfaceLeaf> packed;
  std::array<std::uint16_t, 64> first{};
  std::size_t count = 0;
  for (int word = 0; word < 64; ++word) {
    first[word] = static_cast<std::uint16_t>(count);
    count += count_bits(bits[word]);
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
