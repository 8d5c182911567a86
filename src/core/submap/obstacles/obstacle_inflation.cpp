// SPDX-License-Identifier: BSD-3-Clause
#include "submap/obstacles/obstacle_inflation.hpp"

#include <algorithm>
#include <cmath>

#include "kernels/ball_columns.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;
using geometry::Vec3;

constexpr double kRounding = 1e-5;  // voxel edges; the rounding of floats of this size is a few 1e-6

}  // namespace

void BallWindow::add_balls(const EvidenceBlock& block, double reach) {
  static_assert(kSide == kernels::kColumnWindowSide, "one window");
  constexpr int kFirst = kHalo * kUnitsPerEdge - kUnitsPerEdge / 2;  // puts the centres of voxels at integers
  const auto edges = [](int units) { return static_cast<float>(units) * (1.f / static_cast<float>(kUnitsPerEdge)); };
  std::vector<kernels::BallCenter> centers;
  centers.reserve(block.points.size());
  for (const SurfaceEvidence& point : block.points) {
    const Units3 p = units_of(point) + Units3{kFirst, kFirst, kFirst};
    centers.push_back({edges(p.x), edges(p.y), edges(p.z)});
  }
  const double padded = reach + kRounding;
  kernels::add_balls(centers.data(), centers.size(), static_cast<float>(padded * padded), columns_.data());
}

void BallWindow::copy_to(const Index3& step, Columns* mask) const {
  // Voxel x of the other block has the coordinate x + 16 step in this window, and must lie within the halo.
  const auto first = [](int s) { return s < 0 ? kHalo : 0; };
  const auto last = [](int s) { return s > 0 ? kHalo : kBlockSide; };
  const int shift = kHalo + kBlockSide * step.z;
  for (int y = first(step.y); y < last(step.y); ++y) {
    const int line = (y + kBlockSide * step.y + kHalo) * kSide + kBlockSide * step.x + kHalo;
    std::uint16_t* out = &(*mask)[column_at(0, y)];
    for (int x = first(step.x); x < last(step.x); ++x) {
      const int other = line + x;
      const std::uint32_t column = columns_[static_cast<std::size_t>(other)];
      out[x] |= static_cast<std::uint16_t>(shift >= 0 ? column >> shift : column << -shift);
    }
  }
}

void add_balls(const EvidenceBlock& block, const Index3& step, double reach, Columns* mask) {
  const double squared = (reach + kRounding) * (reach + kRounding);
  const Vec3 corner = Vec3(step.x, step.y, step.z) * kBlockSide;
  const auto first = [](double low) { return std::max(0, static_cast<int>(std::ceil(std::max(low, 0.0)))); };
  const auto last = [](double high) { return std::min(kBlockSide - 1, static_cast<int>(std::floor(high))); };
  for (const SurfaceEvidence& point : block.points) {
    const Vec3 p = local_point(point) - Vec3::Constant(0.5) - corner;
    for (int y = first(p.y() - reach); y <= last(p.y() + reach); ++y) {
      const double rest = squared - (y - p.y()) * (y - p.y());
      for (int x = first(p.x() - reach); x <= last(p.x() + reach); ++x) {
        const double left = rest - (x - p.x()) * (x - p.x());
        if (left <= 0.0) continue;
        const int low = first(p.z() - std::sqrt(left));
        const int high = last(p.z() + std::sqrt(left));
        if (low > high) continue;
        (*mask)[column_at(x, y)] |= static_cast<std::uint16_t>((0xFFFFu >> (kBlockSide - 1 - high)) & (0xFFFFu << low));
      }
    }
  }
}

}  // namespace voxnav::submap
