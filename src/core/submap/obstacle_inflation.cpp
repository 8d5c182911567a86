// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/obstacle_inflation.hpp"

#include <algorithm>
#include <cmath>

#if defined(__SSE2__)
#include <emmintrin.h>
#endif

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

constexpr double kRounding = 1e-5;  // voxel edges; floats of this size carry a few 1e-6

#if !defined(__SSE2__)
/// Bits low to high of a word, none when low > high. 0 <= low, high <= 30.
std::uint32_t bits_from_to(int low, int high) { return low > high ? 0u : (2u << high) - (1u << low); }
#endif

}  // namespace

void BallWindow::add_balls(const EvidenceBlock& block, double reach) {
  const double padded = reach + kRounding;
  for (const EvidenceLeaf& leaf : block.leaves) {
    const Vec3 p = local_point(leaf) + Vec3::Constant(kHalo - 0.5);  // centres of voxels at integers
    add_ball(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()),
             static_cast<float>(padded * padded));
  }
}

/// Per column the voxels from ceil(z - h) to floor(z + h) with h = sqrt(reach^2 - dx^2 - dy^2).
#if defined(__SSE2__)
void BallWindow::add_ball(float x, float y, float z, float squared_reach) {
  const float reach = std::sqrt(squared_reach);
  const int y1 = static_cast<int>(y + reach);
  const int x0 = static_cast<int>(x - reach) & ~3;
  const int x1 = static_cast<int>(x + reach);
  const __m128i one_exponent = _mm_set1_epi32(127);
  const __m128 center_z = _mm_set1_ps(z);
  for (int row = static_cast<int>(y - reach); row <= y1; ++row) {
    const float dy = static_cast<float>(row) - y;
    const float rest = squared_reach - dy * dy;
    if (rest <= 0.f) continue;
    std::uint32_t* line = &columns_[static_cast<std::size_t>(row * kSide)];
    for (int column = x0; column <= x1; column += 4) {
      const __m128 lane = _mm_cvtepi32_ps(_mm_setr_epi32(column, column + 1, column + 2, column + 3));
      const __m128 dx = _mm_sub_ps(lane, _mm_set1_ps(x));
      const __m128 left = _mm_sub_ps(_mm_set1_ps(rest), _mm_mul_ps(dx, dx));
      const __m128 is_in = _mm_cmpgt_ps(left, _mm_setzero_ps());
      const __m128 half = _mm_sqrt_ps(_mm_max_ps(left, _mm_setzero_ps()));
      // Both are above zero, so truncation is floor; ceil(z - h) is never more than floor(z + h) + 1.
      const __m128 low = _mm_sub_ps(center_z, half);
      const __m128i low_floor = _mm_cvttps_epi32(low);
      const __m128i is_above = _mm_castps_si128(_mm_cmpgt_ps(low, _mm_cvtepi32_ps(low_floor)));
      const __m128i first = _mm_sub_epi32(low_floor, is_above);
      const __m128i last = _mm_add_epi32(_mm_cvttps_epi32(_mm_add_ps(center_z, half)), _mm_set1_epi32(1));
      // SSE2 cannot shift lanes by different amounts: powers of two by way of the exponent of floats.
      const auto power = [&](__m128i k) {
        return _mm_cvttps_epi32(_mm_castsi128_ps(_mm_slli_epi32(_mm_add_epi32(k, one_exponent), 23)));
      };
      const __m128i mask = _mm_and_si128(_mm_sub_epi32(power(last), power(first)), _mm_castps_si128(is_in));
      __m128i* out = reinterpret_cast<__m128i*>(line + column);
      _mm_storeu_si128(out, _mm_or_si128(_mm_loadu_si128(out), mask));
    }
  }
}
#else
void BallWindow::add_ball(float x, float y, float z, float squared_reach) {
  const float reach = std::sqrt(squared_reach);
  for (int row = static_cast<int>(y - reach); row <= static_cast<int>(y + reach); ++row) {
    const float dy = static_cast<float>(row) - y;
    const float rest = squared_reach - dy * dy;
    for (int column = static_cast<int>(x - reach); column <= static_cast<int>(x + reach); ++column) {
      const float dx = static_cast<float>(column) - x;
      const float left = rest - dx * dx;
      if (left <= 0.f) continue;
      const float half = std::sqrt(left);
      columns_[static_cast<std::size_t>(row * kSide + column)] |=
          bits_from_to(static_cast<int>(std::ceil(z - half)), static_cast<int>(z + half));
    }
  }
}
#endif

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
