// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>

#include "kernels/column_rows.hpp"
#include "submap/merged/voxel_units.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

/// Whether a submap holds the voxel of a surface point, and the voxels below and above it, for free.
struct FreeAt {
  bool at_point;
  bool below;
  bool above;
};

/// The free voxels of a submap around one block of W (and one voxel below it), as columns side by side, so that queries
/// for point after point need no look-ups of blocks. It serves submaps that are rotated about the vertical only and
/// have voxels as large as those of W. Coordinates are computed in integers.
class FreeWindow {
 public:
  /// @param T_G_W    transform from voxel edges of W to voxel edges of the submap
  /// @param free_of  function that returns the free voxels of a block of the submap, or null if there are none
  template <class FreeOf>
  FreeWindow(const Eigen::Affine3d& T_G_W, const geometry::Index3& block_W, FreeOf&& free_of);

  /// Returns whether the voxel of the submap that contains a surface point, and those below and above it, are free. One
  /// above the window counts as not free.
  FreeAt at(const SurfaceEvidence& evidence) const {
    const Units3 p = units_of(evidence);
    const std::uint32_t z = voxel_at(origin_.z + (std::int64_t{p.z} << kUnitShift));
    const std::uint32_t three =
        column(origin_.x + p.x * along_x_.x + p.y * along_y_.x, origin_.y + p.x * along_x_.y + p.y * along_y_.y) >>
        (z - 1);
    return {(three & 2u) != 0, (three & 1u) != 0, (three & 4u) != 0};
  }
  /// Sets the voxels of the block whose centres lie in free voxels of the submap.
  void add_to(Columns* free) const;

 private:
  static constexpr int kBlocks = 3;  ///< a rotated block touches at most this many blocks along an axis
  static constexpr int kRows = 26;
  static constexpr int kRowLength = kBlocks * geometry::kBlockSide;
  // Fixed-point coordinates in units of the submap (kUnitShift).
  struct Fixed2 {
    std::int64_t x, y;
  };
  struct Fixed3 {
    std::int64_t x, y, z;
  };

  std::uint32_t column(std::int64_t x, std::int64_t y) const {
    return columns_[voxel_at(y) * kRowLength + voxel_at(x)];
  }
  /// Computes the coordinates of the block. @return lowest and highest voxel of the submap that the block touches
  std::array<geometry::Index3, 2> place(const Eigen::Affine3d& T_G_W, const geometry::Index3& block_W);
  void take(const geometry::Index3& block_G, const Columns& free);

  // Fixed-point coordinates in voxel edges that fit 32 bits, so that a vector instruction takes eight at once.
  static constexpr int kCenterShift = 25;
  using Center = kernels::TurnedBlock::Step;

  Fixed3 origin_;             ///< corner of the block, relative to the lowest voxel of the window
  Fixed2 along_x_, along_y_;  ///< step of one unit of W along x and y
  Center center_;             ///< centre of the first voxel of the block
  Center right_, back_;       ///< step of one voxel of W along x and y
  geometry::Index3 low_;      ///< lowest voxel of the window, which lies at the border of a block along x
  int num_rows_ = 0;
  std::array<std::uint32_t, std::size_t{kRows} * kRowLength> columns_;
};

template <class FreeOf>
FreeWindow::FreeWindow(const Eigen::Affine3d& T_G_W, const geometry::Index3& block_W, FreeOf&& free_of) {
  const auto [first, last] = place(T_G_W, block_W);
  const geometry::Index3 first_block = geometry::block_of(first), last_block = geometry::block_of(last);
  for (int z = first_block.z; z <= last_block.z; ++z) {
    for (int y = first_block.y; y <= last_block.y; ++y) {
      for (int x = first_block.x; x <= last_block.x; ++x) {
        const Columns* free = free_of(geometry::Index3{x, y, z});
        if (free) take({x, y, z}, *free);
      }
    }
  }
}

}  // namespace voxnav::submap
