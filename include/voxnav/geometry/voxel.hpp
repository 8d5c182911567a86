// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>

#include "voxnav/geometry/pose.hpp"

namespace voxnav::geometry {

/// Integer cell of a regular grid: cell i covers [i * size, (i + 1) * size) on each axis.
struct Index3 {
  std::int32_t x = 0;
  std::int32_t y = 0;
  std::int32_t z = 0;

  friend bool operator==(const Index3& a, const Index3& b) { return a.x == b.x && a.y == b.y && a.z == b.z; }
  friend bool operator!=(const Index3& a, const Index3& b) { return !(a == b); }
  /// Lexicographic in z, y, x: the order in which blocks are listed wherever output must be deterministic.
  friend bool operator<(const Index3& a, const Index3& b) {
    if (a.z != b.z) return a.z < b.z;
    if (a.y != b.y) return a.y < b.y;
    return a.x < b.x;
  }
  friend Index3 operator+(const Index3& a, const Index3& b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
  friend Index3 operator-(const Index3& a, const Index3& b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
};

inline Index3 index_of(const Vec3& point, double size_m) {
  return {static_cast<std::int32_t>(std::floor(point.x() / size_m)),
          static_cast<std::int32_t>(std::floor(point.y() / size_m)),
          static_cast<std::int32_t>(std::floor(point.z() / size_m))};
}

inline Vec3 center_of(const Index3& index, double size_m) {
  return Vec3(index.x + 0.5, index.y + 0.5, index.z + 0.5) * size_m;
}

/// Side of a block in voxels. All block-based structures share it, so that a receiver stores the blocks of a message
/// without regrouping their voxels.
constexpr int kBlockSide = 16;
constexpr int kBlockShift = 4;
constexpr int kBlockVolume = kBlockSide * kBlockSide * kBlockSide;

inline Index3 block_of(const Index3& voxel) {
  return {voxel.x >> kBlockShift, voxel.y >> kBlockShift, voxel.z >> kBlockShift};
}

/// Offset of a voxel inside its block, x fastest: x + 16 y + 256 z.
inline int offset_in_block(const Index3& voxel) {
  constexpr int kMask = kBlockSide - 1;
  return (voxel.x & kMask) | ((voxel.y & kMask) << kBlockShift) | ((voxel.z & kMask) << (2 * kBlockShift));
}

inline Index3 voxel_at(const Index3& block, int offset) {
  constexpr int kMask = kBlockSide - 1;
  return {block.x * kBlockSide + (offset & kMask), block.y * kBlockSide + ((offset >> kBlockShift) & kMask),
          block.z * kBlockSide + ((offset >> (2 * kBlockShift)) & kMask)};
}

struct Index3Hash {
  std::size_t operator()(const Index3& i) const {
    // 64-bit mix of the three coordinates (finaliser of SplitMix64).
    std::uint64_t h = static_cast<std::uint32_t>(i.x) * 0x9E3779B97F4A7C15ull;
    h ^= static_cast<std::uint32_t>(i.y) * 0xC2B2AE3D27D4EB4Full + (h << 6) + (h >> 2);
    h ^= static_cast<std::uint32_t>(i.z) * 0x165667B19E3779F9ull + (h << 6) + (h >> 2);
    h = (h ^ (h >> 30)) * 0xBF58476D1CE4E5B9ull;
    h = (h ^ (h >> 27)) * 0x94D049BB133111EBull;
    return static_cast<std::size_t>(h ^ (h >> 31));
  }
};

}  // namespace voxnav::geometry
