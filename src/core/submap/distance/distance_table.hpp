// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <limits>

#include "submap/content/content_window.hpp"
#include "submap/distance/distance_block.hpp"

/// The table in which the distances of a block are derived: its voxels and a border of one voxel on every side,
/// coordinates from -1 to 16, x fastest, as in DistanceBlock.
namespace voxnav::submap {

using kernels::kTableSide;
using kernels::table_at;
constexpr std::size_t kTableSize = kernels::kTableVoxels;
using TableOfFloats = std::array<float, kTableSize>;

/// The bits of a row of a ContentWindow that lie in the table.
constexpr std::uint32_t kTableBits = ((1u << kTableSide) - 1) << (ContentWindow::kHalo - 1);

/// A distance greater than all others.
constexpr float kFar = std::numeric_limits<float>::infinity();

/// Returns true if an occupied voxel of a window lies in the table, or at most `beside` voxels outside it on each axis.
/// The range of a coordinate is shifted to begin at 0, so that as an unsigned number it needs only one comparison.
inline bool is_in_table(const geometry::Index3& voxel, int beside = 0) {
  const auto is_in = [&](int c) {
    return static_cast<unsigned>(c + 1 + beside) < kTableSide + 2u * static_cast<unsigned>(beside);
  };
  return is_in(voxel.x) & is_in(voxel.y) & is_in(voxel.z);
}

}  // namespace voxnav::submap
