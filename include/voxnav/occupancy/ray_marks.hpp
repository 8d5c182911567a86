// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "voxnav/occupancy/scan_box.hpp"
#include "voxnav/occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// Marks the voxels that the rays of one scan cross. There are three images of the box, one for rays along each axis,
/// whose words hold 16 voxels in a row along that axis: a ray stays in such a row for several voxels, which are
/// marked at once, and a box of 10^8 voxels fits the cache. One per thread.
class RayMarks {
 public:
  /// All marks must have been cleared; `box` must outlive the casts.
  void begin(const ScanBox& box);
  /// Marks every voxel on the line between two points in the box, both included; voxel edges from the window's corner.
  /// Source: Amanatides and Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987; here over the
  /// two shorter axes only, as runs of voxels along the longest.
  void cast(const geometry::Vec3f& end, const geometry::Vec3& origin);

  bool is_crossed(std::uint32_t block) const {
    return (images_[0].crossed[block] | images_[1].crossed[block] | images_[2].crossed[block]) != 0;
  }
  /// Sets the bits of the crossed voxels of a block.
  void add_to(std::uint32_t block, VoxelBits* bits) const;
  void clear(std::uint32_t block);
  std::size_t memory_bytes() const;

 private:
  static constexpr std::size_t kRows = geometry::kBlockSide * geometry::kBlockSide;
  struct Image {
    std::vector<std::uint16_t> rows;  ///< kRows per block, number b + 16 c where b and c follow the image's axis
    std::vector<std::uint8_t> crossed;
  };
  /// Where in an image the rows of a coordinate lie, for each role that its axis can have. Coordinates from -1 to one
  /// beyond the box: rounding may lead a ray there.
  class RowTable {
   public:
    void build(int num_blocks, std::uint32_t block_stride, std::uint32_t inside);
    std::uint32_t operator[](int cell) const { return rows_[static_cast<std::size_t>(cell + 1)]; }

   private:
    std::vector<std::uint32_t> rows_;
  };
  struct ShortAxis;
  ShortAxis short_axis(int axis, const RowTable& rows, int a, const geometry::Vec3& from,
                       const geometry::Vec3& to) const;
  static void mark_run(Image* image, std::uint32_t block_stride, std::uint32_t row, int first, int last);

  const ScanBox* box_ = nullptr;
  std::array<Image, 3> images_;
  std::array<RowTable, 3> second_, third_;  ///< per axis, when it follows the image's axis or the one after it
};

}  // namespace voxnav::occupancy
