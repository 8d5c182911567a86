// SPDX-License-Identifier: BSD-3-Clause
#include "planning/fences/fence_raster.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxnav::planning {
namespace {

using geometry::Index3;

constexpr int kSide = geometry::kBlockSide;
/// No more columns of blocks, and masks of blocks, are kept than this; all are computed again when they are asked for.
constexpr std::size_t kMaxCovers = 1 << 18;
constexpr std::size_t kMaxMasks = 1 << 15;
/// Rounding must not make a voxel enterable that just touches a fence.
constexpr double kTolerance_m = 1e-9;

/// Edges of a prism within a distance of a rectangle, which are asked for the distance from parts of it.
class NearEdges {
 public:
  NearEdges(const Outline& outline, const Rectangle& rectangle, double reach_m) {
    for_each_edge(outline, [&](const Vec2& a, const Vec2& b) {
      if (distance(rectangle, a, b) <= reach_m) edges_.emplace_back(a, b);
    });
  }
  bool empty() const { return edges_.empty(); }
  double distance_from(const Rectangle& part) const {
    double least = std::numeric_limits<double>::infinity();
    for (const auto& [a, b] : edges_) least = std::min(least, distance(part, a, b));
    return least;
  }

 private:
  std::vector<std::pair<Vec2, Vec2>> edges_;
};

/// The index of the voxel at a height; fences beyond all maps end at the last one.
int height_of(double z_m, double resolution_m) {
  return static_cast<int>(std::floor(std::min(1e9, std::max(-1e9, z_m / resolution_m))));
}

Vec2 center_of(const Rectangle& rectangle) { return 0.5 * (rectangle.min + rectangle.max); }

}  // namespace

FenceRaster::FenceRaster(std::shared_ptr<const Fences> fences, const FenceMargins& margins, double resolution_m)
    : fences_(std::move(fences)), margins_(margins), resolution_m_(resolution_m) {}

Rectangle FenceRaster::square(int x, int y, int side) const {
  const double edge = side * resolution_m_;
  const Vec2 corner = Vec2(1.0 * x, 1.0 * y) * edge;
  return {corner, corner + Vec2::Constant(edge)};
}

std::bitset<kColumns> FenceRaster::outside_area(const Prism& area, int x, int y) const {
  std::bitset<kColumns> out;
  const Rectangle whole = square(x, y, kSide);
  const NearEdges edges(area.outline, whole, margins_.area_m + kTolerance_m);
  if (edges.empty()) return is_inside(area.outline, center_of(whole)) ? out : out.set();
  for (int column = 0; column < kColumns; ++column) {
    const Rectangle part = square(x * kSide + column % kSide, y * kSide + column / kSide, 1);
    const bool is_kept = edges.distance_from(part) > margins_.area_m + kTolerance_m;
    out[static_cast<std::size_t>(column)] = !is_kept || !is_inside(area.outline, center_of(part));
  }
  return out;
}

void FenceRaster::add_zone(const Prism& zone, int x, int y, Cover* cover) const {
  const Rectangle whole = square(x, y, kSide);
  const double reach_m = margins_.zone_m + kTolerance_m;
  const NearEdges edges(zone.outline, whole, reach_m);
  if (edges.empty() && !is_inside(zone.outline, center_of(whole))) return;
  ZoneBands out;
  out.some = {std::numeric_limits<int>::max(), std::numeric_limits<int>::min()};
  out.all = {std::numeric_limits<int>::min(), std::numeric_limits<int>::max()};
  for (int column = 0; column < kColumns; ++column) {
    const Rectangle part = square(x * kSide + column % kSide, y * kSide + column / kSide, 1);
    const double flat_m = is_inside(zone.outline, center_of(part)) ? 0.0 : edges.distance_from(part);
    if (flat_m > reach_m) {
      out.all = {0, -1};
      continue;
    }
    const double above_m = std::sqrt(std::max(0.0, reach_m * reach_m - flat_m * flat_m));
    Band& band = out.bands[static_cast<std::size_t>(column)];
    band = {height_of(zone.min_z - above_m, resolution_m_), height_of(zone.max_z + above_m, resolution_m_)};
    out.some = {std::min(out.some.low, band.low), std::max(out.some.high, band.high)};
    out.all = {std::max(out.all.low, band.low), std::min(out.all.high, band.high)};
  }
  if (out.some.low <= out.some.high) cover->zones.push_back(out);
}

std::unique_ptr<FenceRaster::Cover> FenceRaster::make_cover(int x, int y) const {
  auto out = std::make_unique<Cover>();
  if (fences_->area()) out->outside = outside_area(*fences_->area(), x, y);
  out->is_all_outside = out->outside.all();
  if (!out->is_all_outside) {
    for (const Prism& zone : fences_->zones()) add_zone(zone, x, y, out.get());
  }
  return out->outside.any() || !out->zones.empty() ? std::move(out) : nullptr;
}

FenceRaster::Cover* FenceRaster::cover(int x, int y) const {
  if (covers_.size() > kMaxCovers) covers_.clear();
  const auto [it, is_new] = covers_.try_emplace(Index3{x, y, 0}, nullptr);
  if (is_new) it->second = make_cover(x, y);
  return it->second.get();
}

bool FenceRaster::mask(const Index3& block, BlockMask* hard) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  const Share here = share(block.x, block.y, block.z);
  if (here == Share::kNone) return false;
  if (here == Share::kAll) {
    hard->set();
    return true;
  }
  if (masks_.size() > kMaxMasks) masks_.clear();
  const auto [it, is_new] = masks_.try_emplace(block, nullptr);
  if (is_new) it->second = make_mask(*cover(block.x, block.y), block.z);
  *hard |= *it->second;
  return true;
}

std::unique_ptr<BlockMask> FenceRaster::make_mask(const Cover& there, int z) const {
  auto out = std::make_unique<BlockMask>();
  const int lowest = z * kSide;
  for (std::size_t column = 0; column < kColumns; ++column) {
    std::uint32_t bits = there.outside[column] ? kWholeColumn : 0u;
    for (const ZoneBands& zone : there.zones) {
      const Band& band = zone.bands[column];
      const int low = std::max(0, band.low - lowest), high = std::min(kSide - 1, band.high - lowest);
      if (low <= high) bits |= ((2u << high) - 1u) & ~((1u << low) - 1u);
    }
    for (; bits != 0; bits &= bits - 1) out->set(static_cast<std::size_t>(__builtin_ctz(bits)) * kColumns + column);
  }
  return out;
}

FenceRaster::Share FenceRaster::share(int x, int y, int z) const {
  const Cover* there = cover(x, y);
  if (there == nullptr) return Share::kNone;
  if (there->is_all_outside) return Share::kAll;
  const int low = z * kSide, high = low + kSide - 1;
  bool is_some = there->outside.any();
  for (const ZoneBands& zone : there->zones) {
    if (zone.all.low <= low && zone.all.high >= high) return Share::kAll;
    is_some = is_some || (zone.some.low <= high && zone.some.high >= low);
  }
  return is_some ? Share::kSome : Share::kNone;
}

bool FenceRaster::is_at_edge(int x, int y, int z) const {
  const Share here = share(x, y, z);
  if (here != Share::kAll) return here == Share::kSome;
  for (int dz = -1; dz <= 1; ++dz) {
    for (int dy = -1; dy <= 1; ++dy) {
      for (int dx = -1; dx <= 1; ++dx) {
        if (share(x + dx, y + dy, z + dz) != Share::kAll) return true;
      }
    }
  }
  return false;
}

bool FenceRaster::is_deep_outside(int x, int y) const {
  const auto is_outside = [this](int i, int j) {
    const Cover* there = cover(i, j);
    return there != nullptr && there->is_all_outside;
  };
  if (!is_outside(x, y)) return false;
  if (cover(x, y)->is_deep) return *cover(x, y)->is_deep;
  bool is_deep = true;
  for (int i = 0; i < 9; ++i) is_deep = is_deep && is_outside(x + i % 3 - 1, y + i / 3 - 1);
  cover(x, y)->is_deep = is_deep;
  return is_deep;
}

void FenceRaster::add_edge_blocks(const geometry::Aabb& box, std::vector<Index3>* out) const {
  if (box.empty()) return;
  const double side = kSide * resolution_m_;
  const Index3 low = geometry::index_of(box.min, side), high = geometry::index_of(box.max, side);
  const std::lock_guard<std::mutex> lock(mutex_);
  for (int y = low.y; y <= high.y; ++y) {
    for (int x = low.x; x <= high.x; ++x) {
      if (cover(x, y) == nullptr || is_deep_outside(x, y)) continue;
      for (int z = low.z; z <= high.z; ++z) {
        if (is_at_edge(x, y, z)) out->push_back({x, y, z});
      }
    }
  }
}

}  // namespace voxnav::planning
