// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/occupancy/scan_box.hpp"

namespace voxnav::occupancy {

/// Marks the voxels that the rays of one scan cross: a byte per voxel, so that marking is a store that waits for
/// nothing, and one per row of 64 voxels, so that what was not crossed is not looked at. Several threads may cast into
/// the same marks: all of them store the same value.
class RayMarks {
 public:
  static constexpr std::uint8_t kCrossed = 0xFF;

  /// All marks must have been taken; `box` must outlive the casts.
  void begin(const ScanBox& box);
  /// Marks every voxel on the line between two points in the box, both included; voxel edges from the window's corner.
  /// Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987; here slab by
  /// slab along the longest axis, four slabs at a time.
  void cast(const geometry::Vec3f& end, const geometry::Vec3& origin);

  bool is_block_crossed(std::uint32_t block) const;
  bool is_row_crossed(std::uint32_t block, int row) const { return rows_[64 * std::size_t{block} + row] != 0; }
  /// 64 bytes, kCrossed or 0.
  const std::uint8_t* row(std::uint32_t block, int row) const {
    return voxels_.data() + 64 * (64 * std::size_t{block} + row);
  }
  void clear(std::uint32_t block);
  std::size_t memory_bytes() const { return voxels_.capacity() + rows_.capacity(); }

 private:
  /// Four voxels at a time.
  template <class Addresses>
  void mark(const Addresses& addresses);

  const ScanBox* box_ = nullptr;
  std::vector<std::uint8_t> voxels_;  ///< 4096 per block of the box; all 0 between scans
  std::vector<std::uint8_t> rows_;    ///< 64 per block
};

}  // namespace voxnav::occupancy
