// SPDX-License-Identifier: BSD-3-Clause
#include "submap/obstacles/obstacle_inflation.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/lanes.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

using namespace kernels::lanes;  // NOLINT: the vector types of this file

constexpr double kRounding = 1e-5;  // voxel edges; floats of this size carry a few 1e-6

/// Bits low to high of each lane, none when low > high; from 0 to 30, where low is high + 1 at most and not 31.
template <bool kIsWide>
VOXNAV_INLINE Words bits_from_to(Ints low, Ints high) {
  if (kIsWide) return (~Words{} << reinterpret_cast<Words>(low)) & ~((~Words{} - 1u) << reinterpret_cast<Words>(high));
  // Older processors cannot shift lanes by different amounts: powers of two by way of the exponent of floats.
  const auto power = [](Ints k) {
    return reinterpret_cast<Words>(truncated(reinterpret_cast<Floats>((k + 127) << 23)));
  };
  return 2u * power(high) - power(low);
}

/// Of eight columns the voxels from ceil(z - h) to floor(z + h), h^2 = rest - dx^2.
template <bool kIsWide>
VOXNAV_INLINE void add_eight(Floats squared_dx, float z, float rest, std::uint32_t* columns) {
  constexpr int kTop = BallWindow::kSide;
  const Floats left = rest - squared_dx;
  const Floats half = exact_root(larger(left, Floats{}));
  // What is cut off is above zero, so truncation is floor; the lower end never is above the voxel behind the upper one.
  const Ints low = kTop - truncated((kTop - z) + half);
  const Words bits = bits_from_to<kIsWide>(low, truncated(z + half));
  store(loaded<Words>(columns) | (left > Floats{} ? bits : Words{}), columns);
}

/// Eights begin at the same columns for every ball: what one has just stored could not be loaded in other pieces.
template <bool kIsWide>
VOXNAV_INLINE void add_ball(float x, float y, float z, float squared_reach, std::uint32_t* columns) {
  constexpr int kMostEights = 3;
  const float reach = std::sqrt(squared_reach);
  const int first = static_cast<int>(x - reach) & ~(kLanes - 1);
  const int last = static_cast<int>(x + reach);
  Floats squared_dx[kMostEights];
  for (int i = 0; i < kMostEights; ++i) {
    const Floats dx = static_cast<float>(first + i * kLanes) + Floats{0, 1, 2, 3, 4, 5, 6, 7} - x;
    squared_dx[i] = dx * dx;
  }
  std::uint32_t* to = columns + first + static_cast<int>(y - reach) * BallWindow::kSide;
  for (int row = static_cast<int>(y - reach); row <= static_cast<int>(y + reach); ++row, to += BallWindow::kSide) {
    const float dy = static_cast<float>(row) - y;
    const float rest = squared_reach - dy * dy;
    if (rest <= 0.f) continue;
    add_eight<kIsWide>(squared_dx[0], z, rest, to);
    if (last >= first + kLanes) add_eight<kIsWide>(squared_dx[1], z, rest, to + kLanes);
    if (last >= first + 2 * kLanes) add_eight<kIsWide>(squared_dx[2], z, rest, to + 2 * kLanes);
  }
}

template <bool kIsWide>
VOXNAV_INLINE void add_all(const std::vector<EvidenceLeaf>& leaves, float squared_reach, std::uint32_t* columns) {
  constexpr int kFirst = BallWindow::kHalo * kUnitsPerEdge - kUnitsPerEdge / 2;  // centres of voxels at integers
  for (const EvidenceLeaf& leaf : leaves) {
    const Units3 p = units_of(leaf) + Units3{kFirst, kFirst, kFirst};
    const auto edges = [](int units) { return static_cast<float>(units) * (1.f / static_cast<float>(kUnitsPerEdge)); };
    add_ball<kIsWide>(edges(p.x), edges(p.y), edges(p.z), squared_reach, columns);
  }
}
void add_all_plain(const std::vector<EvidenceLeaf>& leaves, float squared_reach, std::uint32_t* columns) {
  add_all<false>(leaves, squared_reach, columns);
}
VOXNAV_WIDE void add_all_wide(const std::vector<EvidenceLeaf>& leaves, float squared_reach, std::uint32_t* columns) {
  add_all<true>(leaves, squared_reach, columns);
}

}  // namespace

void BallWindow::add_balls(const EvidenceBlock& block, double reach) {
  const double padded = reach + kRounding;
  (kernels::is_wide() ? add_all_wide : add_all_plain)(block.leaves, static_cast<float>(padded * padded),
                                                      columns_.data());
}

void BallWindow::copy_to(const Index3& step, Columns* mask) const {
  // Voxel x of the other block is x + 16 step here, and must lie within the halo.
  const auto first = [](int s) { return s < 0 ? kHalo : 0; };
  const auto last = [](int s) { return s > 0 ? kHalo : kBlockSide; };
  const int shift = kHalo + kBlockSide * step.z;
  for (int y = first(step.y); y < last(step.y); ++y) {
    const int line = (y + kBlockSide * step.y + kHalo) * kSide + kBlockSide * step.x + kHalo;
    std::uint16_t* out = &(*mask)[static_cast<std::size_t>(y * kBlockSide)];
    for (int x = first(step.x); x < last(step.x); ++x) {
      const std::uint32_t column = columns_[static_cast<std::size_t>(line + x)];
      out[x] |= static_cast<std::uint16_t>(shift >= 0 ? column >> shift : column << -shift);
    }
  }
}

void add_balls(const EvidenceBlock& block, const Index3& step, double reach, Columns* mask) {
  const double squared = (reach + kRounding) * (reach + kRounding);
  const Vec3 corner = Vec3(step.x, step.y, step.z) * kBlockSide;
  const auto first = [](double low) { return std::max(0, static_cast<int>(std::ceil(std::max(low, 0.0)))); };
  const auto last = [](double high) { return std::min(kBlockSide - 1, static_cast<int>(std::floor(high))); };
  for (const EvidenceLeaf& leaf : block.leaves) {
    const Vec3 p = local_point(leaf) - Vec3::Constant(0.5) - corner;
    for (int y = first(p.y() - reach); y <= last(p.y() + reach); ++y) {
      const double rest = squared - (y - p.y()) * (y - p.y());
      for (int x = first(p.x() - reach); x <= last(p.x() + reach); ++x) {
        const double left = rest - (x - p.x()) * (x - p.x());
        if (left <= 0.0) continue;
        const int low = first(p.z() - std::sqrt(left));
        const int high = last(p.z() + std::sqrt(left));
        if (low > high) continue;
        (*mask)[static_cast<std::size_t>(x + kBlockSide * y)] |=
            static_cast<std::uint16_t>((0xFFFFu >> (kBlockSide - 1 - high)) & (0xFFFFu << low));
      }
    }
  }
}

}  // namespace voxnav::submap
