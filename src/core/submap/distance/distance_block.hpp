// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "kernels/free_distances.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::submap {

/// Signed distances at the voxel centres of one block and of a border of one voxel around it, so that every point of
/// the block can be interpolated from this alone.
class DistanceBlock {
 public:
  static constexpr int kSide = kernels::kTableSide;
  static constexpr std::int16_t kNone = kernels::kNoDistance;

  explicit DistanceBlock(double band) : scale_(static_cast<float>(band / 32767.0)) { codes_.fill(kNone); }

  /// Reads the distances [voxel edges] at the 2^3 voxels from (x, y, z) on, x fastest; coordinates are from -1 to 15.
  /// @return false if one of the voxels has none
  bool corners(int x, int y, int z, std::array<float, 8>* values) const;
  /// @param distance  voxel edges, between -band and band
  void set(int x, int y, int z, float distance);
  /// Computes the distances of the free voxels within `band` of a surface point.
  /// @param room  working memory
  void measure_free(const kernels::VoxelWindow& window, float band, kernels::SquaredDistances* room) {
    kernels::measure_free(window, band, scale_, room, codes_.data());
  }
  bool is_empty() const;

  mutable std::atomic<bool> was_used{false};  ///< whether the block was used since the cache last passed over it

 private:
  float scale_;
  std::array<std::int16_t, kernels::kTableVoxels> codes_;
};

}  // namespace voxnav::submap
