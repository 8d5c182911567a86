// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/ground_cover.hpp"

#include <cmath>

namespace voxnav::planning {
namespace {

using geometry::Index3;

/// Columns are looked at within this distance, and every second one is enough.
constexpr double kRadius_m = 10.0;
constexpr int kStride = 2;
/// The share of the columns with content that must cover the voxel, and the share of all that must have content.
constexpr double kCovered = 0.95, kKnown = 0.5;

enum class Column { kUnknown, kOpen, kCovers };

/// What a column says of the height z: it covers it if nothing is free up to there and something is occupied above.
Column judge(const ClearanceField::Impl& field, const Index3& voxel) {
  constexpr int kSide = geometry::kBlockSide;
  const int at = column_at(voxel.x & (kSide - 1), voxel.y & (kSide - 1));
  const int lowest = field.bounds().low.z >> geometry::kBlockShift;
  const int highest = field.bounds().high.z >> geometry::kBlockShift;
  bool has_free = false;
  for (int z = lowest; z <= highest; ++z) {
    const ClearanceBlock* block = field.block_of({voxel.x, voxel.y, z * kSide});
    if (block == nullptr) continue;
    const std::uint32_t occupied = block->occupied[at];
    const std::uint32_t free = kWholeColumn & ~(occupied | block->unknown[at]);
    const int above = voxel.z - z * kSide + 1;  // lowest height of this block that is above the voxel
    const std::uint32_t below_mask = above <= 0 ? 0u : above >= kSide ? kWholeColumn : (1u << above) - 1u;
    if ((free & below_mask) != 0) return Column::kOpen;
    const std::uint32_t roof = occupied & ~below_mask, air = free & ~below_mask;
    if (roof != 0) {
      const bool is_open = air != 0 && __builtin_ctz(air) < __builtin_ctz(roof);
      return has_free || is_open ? Column::kOpen : Column::kCovers;
    }
    has_free = has_free || air != 0;
  }
  return has_free ? Column::kOpen : Column::kUnknown;
}

}  // namespace

bool is_below_ground(const ClearanceField::Impl& field, const Index3& voxel) {
  if (judge(field, voxel) != Column::kCovers) return false;
  const int reach = static_cast<int>(kRadius_m / field.resolution_m());
  int num_all = 0, num_known = 0, num_covering = 0;
  for (int y = -reach; y <= reach; y += kStride) {
    for (int x = -reach; x <= reach; x += kStride) {
      if (x * x + y * y > reach * reach) continue;
      const Column there = judge(field, voxel + Index3{x, y, 0});
      ++num_all;
      num_known += there != Column::kUnknown ? 1 : 0;
      num_covering += there == Column::kCovers ? 1 : 0;
    }
  }
  return num_covering >= kCovered * num_known && num_known >= kKnown * num_all;
}

}  // namespace voxnav::planning
