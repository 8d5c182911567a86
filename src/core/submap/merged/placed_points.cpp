// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/placed_points.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <utility>

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::kBlockSide;

constexpr int kBlockUnits = kBlockSide * kUnitsPerEdge;

/// Returns the voxel of a coordinate, rounded down also if it is negative.
int voxel_of(int units) { return (units >= 0 ? units : units - (kUnitsPerEdge - 1)) / kUnitsPerEdge; }

/// The range of voxels of a block from `low` to `high` along one axis.
struct Range {
  Range(int low, int high) : first(std::max(0, voxel_of(low))), last(std::min(kBlockSide - 1, voxel_of(high))) {}
  int first, last;
};

}  // namespace

std::uint32_t PlacedPoints::block(const Index3& index) {
  const auto added = numbers_.try_emplace(index, static_cast<std::uint32_t>(blocks_.size()));
  if (added.second) blocks_.emplace_back();
  return added.first->second;
}

void PlacedPoints::reserve(std::size_t count, std::size_t num_blocks) {
  blocks_.reserve(num_blocks);
  numbers_.reserve(num_blocks);
  added_.resize(count);
  block_of_added_.resize(count);
}

void PlacedPoints::sort() {
  std::uint32_t next = 0;
  for (Block& block : blocks_) {
    for (std::uint32_t& first : block.first) next += std::exchange(first, next);
  }
  points_.resize(num_added_);
  for (std::size_t i = 0; i < num_added_; ++i) {
    points_[blocks_[block_of_added_[i]].first[added_[i].offset & 255u]++] = added_[i];
  }
  // Counting moved each entry on to where the next column begins, so all entries are moved back by one column.
  for (Block& block : blocks_) {
    for (std::size_t i = block.first.size() - 1; i > 0; --i) block.first[i] = block.first[i - 1];
  }
  std::uint32_t begin = 0;
  for (Block& block : blocks_) block.first.front() = std::exchange(begin, block.first.back());
  added_ = {};
  block_of_added_ = {};
}

const PlacedPoints::Block* PlacedPoints::find(const Index3& index) const {
  const auto found = numbers_.find(index);
  return found == numbers_.end() ? nullptr : &blocks_[found->second];
}

const PlacedPoints::Block* PlacedPoints::Around::at(const Index3& step) const {
  if (step == Index3{}) return center_;
  if (std::max({std::abs(step.x), std::abs(step.y), std::abs(step.z)}) > 1) return points_->find(index_ + step);
  const int position = step.x + 1 + 3 * (step.y + 1) + 9 * (step.z + 1);
  const auto i = static_cast<std::size_t>(position);
  if (((looked_up_ >> i) & 1) == 0) near_[i] = points_->find(index_ + step);
  looked_up_ |= 1u << i;
  return near_[i];
}

bool PlacedPoints::Around::has_within(const Units3& p, double distance) const {
  const double in_units = distance * kUnitsPerEdge;
  const int reach = static_cast<int>(std::ceil(in_units));
  const bool stays_inside = std::min({p.x, p.y, p.z}) >= reach && std::max({p.x, p.y, p.z}) < kBlockUnits - reach;
  if (stays_inside) return center_ && points_->has_within(*center_, p, reach, in_units * in_units);
  const auto block_at = [](int c) { return voxel_of(c) >> geometry::kBlockShift; };
  const Index3 first{block_at(p.x - reach), block_at(p.y - reach), block_at(p.z - reach)};
  const Index3 last{block_at(p.x + reach), block_at(p.y + reach), block_at(p.z + reach)};
  for (int z = first.z; z <= last.z; ++z) {
    for (int y = first.y; y <= last.y; ++y) {
      for (int x = first.x; x <= last.x; ++x) {
        const Block* block = at({x, y, z});
        const Units3 from = p - Units3{x * kBlockUnits, y * kBlockUnits, z * kBlockUnits};
        if (block && points_->has_within(*block, from, reach, in_units * in_units)) return true;
      }
    }
  }
  return false;
}

bool PlacedPoints::has_within(const Block& block, const Units3& p, int reach, double squared) const {
  const Range xs(p.x - reach, p.x + reach), ys(p.y - reach, p.y + reach), zs(p.z - reach, p.z + reach);
  const unsigned layers = (2u << zs.last) - (1u << zs.first);
  for (int y = ys.first; y <= ys.last; ++y) {
    for (int x = xs.first; x <= xs.last; ++x) {
      const std::size_t column = column_at(x, y);
      if ((block.occupied[column] & layers) == 0) continue;
      for (std::uint32_t i = block.first[column]; i < block.first[column + 1]; ++i) {
        const Units3 d = units_of(points_[i]) - p;
        const auto square = [](int c) { return static_cast<std::int64_t>(c) * c; };
        if (static_cast<double>(square(d.x) + square(d.y) + square(d.z)) < squared) return true;
      }
    }
  }
  return false;
}

}  // namespace voxnav::submap
