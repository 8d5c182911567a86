// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/free_distances.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "kernels/lanes.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

constexpr float kFar = std::numeric_limits<float>::infinity();
constexpr float kMostCode = 32767.f;
constexpr std::uint32_t kTable = ((1u << kTableSide) - 1) << (kWindowHalo - 1);  // of a row of the window

/// Returns the first and the last voxel centre of the table within `reach` of c.
struct Range {
  int first, last;
};
VOXNAV_INLINE Range around(float c, float reach) {
  const int low = static_cast<int>(c - reach + 16.0f) - 15;  // rounded up, without a call
  const int high = static_cast<int>(c + reach + 16.0f) - 16;
  return {low < -1 ? -1 : low, high > kWindowBlockSide ? kWindowBlockSide : high};
}

/// Returns the rows of each layer of the table that contain free voxels: row y is bit y + 1.
using FreeRows = std::array<std::uint32_t, kTableSide>;
FreeRows rows_with_free(const VoxelWindow& window) {
  FreeRows out{};
  std::uint32_t* layer = out.data();
  for (int z = -1; z <= kWindowBlockSide; ++z, ++layer) {
    for (int y = -1; y <= kWindowBlockSide; ++y) {
      if ((window.free(y, z) & kTable) != 0) *layer |= 1u << (y + 1);
    }
  }
  return out;
}

/// Updates the squared distances of the rows around a point. Rows are processed whole, as a few vectors, which costs
/// less than finding where the ball ends in each row; rows without free voxels are skipped.
template <int kVectors>
VOXNAV_INLINE void splat(const VoxelWindow& window, const FreeRows& free, const WindowPoint& point, float band,
                         SquaredDistances* squared) {
  constexpr int kLength = kVectors * kLanes;
  constexpr std::uint32_t kRow = (1u << kLength) - 1;
  const float band2 = band * band * 1.0001f;
  int first = around(point[0], band).first;
  if (first > kWindowBlockSide + 1 - kLength) first = kWindowBlockSide + 1 - kLength;
  Floats along_x[kVectors];
  for (int i = 0; i < kVectors; ++i) {
    const Floats dx = static_cast<float>(first + i * kLanes) + Floats{0, 1, 2, 3, 4, 5, 6, 7} - point[0];
    along_x[i] = dx * dx;
  }
  const Range ys = around(point[1], band), zs = around(point[2], band);
  if (ys.first > ys.last) return;
  const std::uint32_t in_reach = (2u << (ys.last + 1)) - (1u << (ys.first + 1));
  const std::uint32_t* layer = free.data() + (zs.first + 1);
  for (int z = zs.first; z <= zs.last; ++z, ++layer) {
    const float dz = static_cast<float>(z) - point[2];
    for (std::uint32_t rows = *layer & in_reach; rows != 0; rows &= rows - 1) {
      const int y = __builtin_ctz(rows) - 1;
      const float dy = static_cast<float>(y) - point[1];
      const float base = dy * dy + dz * dz;
      if (base > band2 || ((window.free(y, z) >> (first + kWindowHalo)) & kRow) == 0) continue;
      float* row = &(*squared)[table_at(first, y, z)];
      for (int i = 0; i < kVectors; ++i, row += kLanes) {
        store(smaller(base + along_x[i], loaded<Floats>(row)), row);
      }
    }
  }
}

VOXNAV_INLINE void splat_all(const VoxelWindow& window, float band, SquaredDistances* squared) {
  const FreeRows free = rows_with_free(window);
  const float lowest = -1.0f - band, highest = kWindowBlockSide + band;
  for (std::size_t i = 0; i < window.num_points; ++i) {
    const WindowPoint& point = window.points[i];
    const float low = std::min({point[0], point[1], point[2]}), high = std::max({point[0], point[1], point[2]});
    if (low < lowest || high > highest) continue;  // too far away
    if (band <= 3.5f) {
      splat<1>(window, free, point, band, squared);
    } else {
      splat<2>(window, free, point, band, squared);
    }
  }
}

/// Writes the distances of those of eight voxels in a row that are free and near enough.
VOXNAV_INLINE void store_codes(Floats distance, Ints which, float scale, std::int16_t* codes) {
  using Codes = std::int16_t __attribute__((vector_size(16)));
  const Floats code = smaller(distance / scale, Floats{} + kMostCode) + 0.5f;
  store(__builtin_convertvector(which ? truncated(code) : Ints{} + kNoDistance, Codes), codes);
}

VOXNAV_INLINE void take_free(const VoxelWindow& window, float band, float scale, const SquaredDistances& squared,
                             std::int16_t* codes) {
  for (int z = -1; z <= kWindowBlockSide; ++z) {
    for (int y = -1; y <= kWindowBlockSide; ++y) {
      const std::uint32_t free = window.free(y, z);
      if ((free & kTable) == 0) continue;
      for (const int x : {-1, kLanes - 1, kWindowBlockSide + 1 - kLanes}) {  // the last two overlap
        const Words bits = Words{} + (free >> (x + kWindowHalo));
        const Floats distance_sq = loaded<Floats>(&squared[table_at(x, y, z)]);
        const Ints is_near = ((bits & Words{1, 2, 4, 8, 16, 32, 64, 128}) != 0) & (distance_sq <= band * band);
        store_codes(exact_root(distance_sq), is_near, scale, codes + table_at(x, y, z));
      }
    }
  }
}

VOXNAV_INLINE void measure(const VoxelWindow& window, float band, float scale, SquaredDistances* squared,
                           std::int16_t* codes) {
  squared->fill(kFar);
  splat_all(window, band, squared);
  take_free(window, band, scale, *squared, codes);
}
void measure_plain(const VoxelWindow& window, float band, float scale, SquaredDistances* squared, std::int16_t* codes) {
  measure(window, band, scale, squared, codes);
}
VOXNAV_WIDE void measure_wide(const VoxelWindow& window, float band, float scale, SquaredDistances* squared,
                              std::int16_t* codes) {
  measure(window, band, scale, squared, codes);
}

}  // namespace

void measure_free(const VoxelWindow& window, float band, float scale, SquaredDistances* squared, std::int16_t* codes) {
  (is_wide() ? measure_wide : measure_plain)(window, band, scale, squared, codes);
}

void reference::measure_free(const VoxelWindow& window, float band, float scale, std::int16_t* codes) {
  for (int z = -1; z <= kWindowBlockSide; ++z) {
    for (int y = -1; y <= kWindowBlockSide; ++y) {
      for (int x = -1; x <= kWindowBlockSide; ++x) {
        codes[table_at(x, y, z)] = kNoDistance;
        if (((window.free(y, z) >> (x + kWindowHalo)) & 1u) == 0) continue;
        float nearest_sq = kFar;
        for (std::size_t i = 0; i < window.num_points; ++i) {
          const WindowPoint& point = window.points[i];
          const float dx = static_cast<float>(x) - point[0], dy = static_cast<float>(y) - point[1];
          const float dz = static_cast<float>(z) - point[2];
          nearest_sq = std::min(nearest_sq, (dy * dy + dz * dz) + dx * dx);
        }
        if (!(nearest_sq <= band * band)) continue;
        const float code = std::min(std::sqrt(nearest_sq) / scale, kMostCode) + 0.5f;
        codes[table_at(x, y, z)] = static_cast<std::int16_t>(code);
      }
    }
  }
}

}  // namespace voxnav::kernels
