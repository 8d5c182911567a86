// SPDX-License-Identifier: BSD-3-Clause
#include "kernels/ball_columns.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/lanes.hpp"

namespace voxnav::kernels {
namespace {

using namespace lanes;  // NOLINT: the vector types of this file

constexpr int kSide = kColumnWindowSide;

/// Returns a mask of the bits low to high in each lane, which is empty if low > high. Bits are from 0 to 30; low is at
/// most high + 1 and not 31.
template <bool kIsWide>
VOXNAV_INLINE Words bits_from_to(Ints low, Ints high) {
  if (kIsWide) return (~Words{} << reinterpret_cast<Words>(low)) & ~((~Words{} - 1u) << reinterpret_cast<Words>(high));
  // Older processors cannot shift lanes by different amounts, so powers of two are made through the exponent of floats.
  const auto power = [](Ints k) {
    return reinterpret_cast<Words>(truncated(reinterpret_cast<Floats>((k + 127) << 23)));
  };
  return 2u * power(high) - power(low);
}

/// Returns, for eight columns, the voxels from ceil(z - h) to floor(z + h) with h^2 = rest - dx^2.
template <bool kIsWide>
VOXNAV_INLINE void add_eight(Floats squared_dx, float z, float rest, std::uint32_t* columns) {
  const Floats left = rest - squared_dx;
  const Floats half = exact_root(larger(left, Floats{}));
  // The values are positive, so truncation is floor. The lower end is at most one voxel above the upper end.
  const Ints low = kSide - truncated((kSide - z) + half);
  const Words bits = bits_from_to<kIsWide>(low, truncated(z + half));
  store(loaded<Words>(columns) | (left > Floats{} ? bits : Words{}), columns);
}

/// Groups of eight columns begin at the same columns for every ball: a load that overlaps two recent stores would have
/// to wait for both.
template <bool kIsWide>
VOXNAV_INLINE void add_ball(const BallCenter& center, float squared_reach, std::uint32_t* columns) {
  constexpr int kMostEights = 3, kSecond = kLanes, kThird = 2 * kLanes;
  const float reach = std::sqrt(squared_reach);
  const int first = static_cast<int>(center.x - reach) & ~(kLanes - 1);
  const int last = static_cast<int>(center.x + reach);
  Floats squared_dx[kMostEights];
  for (int i = 0; i < kMostEights; ++i) {
    const Floats dx = static_cast<float>(first + i * kLanes) + Floats{0, 1, 2, 3, 4, 5, 6, 7} - center.x;
    squared_dx[i] = dx * dx;
  }
  const int first_row = static_cast<int>(center.y - reach), last_row = static_cast<int>(center.y + reach);
  std::uint32_t* to = columns + (first + first_row * kSide);
  for (int row = first_row; row <= last_row; ++row, to += kSide) {
    const float dy = static_cast<float>(row) - center.y;
    const float rest = squared_reach - dy * dy;
    if (rest <= 0.f) continue;
    add_eight<kIsWide>(squared_dx[0], center.z, rest, to);
    if (last >= first + kSecond) add_eight<kIsWide>(squared_dx[1], center.z, rest, to + kSecond);
    if (last >= first + kThird) add_eight<kIsWide>(squared_dx[2], center.z, rest, to + kThird);
  }
}

void add_plain(const BallCenter* centers, std::size_t n, float squared_reach, std::uint32_t* columns) {
  for (std::size_t i = 0; i < n; ++i) add_ball<false>(centers[i], squared_reach, columns);
}
VOXNAV_WIDE void add_wide(const BallCenter* centers, std::size_t n, float squared_reach, std::uint32_t* columns) {
  for (std::size_t i = 0; i < n; ++i) add_ball<true>(centers[i], squared_reach, columns);
}

}  // namespace

void add_balls(const BallCenter* centers, std::size_t n, float squared_reach, std::uint32_t* columns) {
  (is_wide() ? add_wide : add_plain)(centers, n, squared_reach, columns);
}

void reference::add_balls(const BallCenter* centers, std::size_t n, float squared_reach, std::uint32_t* columns) {
  for (std::size_t i = 0; i < n; ++i) {
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        const float dx = static_cast<float>(x) - centers[i].x, dy = static_cast<float>(y) - centers[i].y;
        const float left = (squared_reach - dy * dy) - dx * dx;
        if (!(left > 0.f)) continue;
        const float half = std::sqrt(left), z = centers[i].z;
        const int low = kSide - static_cast<int>((kSide - z) + half), high = static_cast<int>(z + half);
        for (int k = low; k <= high; ++k) columns[x + kSide * y] |= 1u << k;
      }
    }
  }
}

}  // namespace voxnav::kernels
