// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <memory>

#include "kernels/free_distances.hpp"
#include "submap/content/compressed_field.hpp"

namespace voxnav::submap {

/// Signed distances at the voxel centres of one block and one voxel around it, so that every point of the block can be
/// interpolated from this alone.
class DistanceBlock {
 public:
  static constexpr int kSide = kernels::kTableSide;
  static constexpr std::int16_t kNone = kernels::kNoDistance;

  explicit DistanceBlock(double band) : scale_(static_cast<float>(band / 32767.0)) { codes_.fill(kNone); }

  /// Distances at the 2^3 voxels from (x, y, z) on, x fastest, voxel edges; from -1 to 15. @return false when one of
  /// them has none
  bool corners(int x, int y, int z, std::array<float, 8>* values) const;
  /// @param distance voxel edges, between -band and band
  void set(int x, int y, int z, float distance);
  /// Takes the distances of the free voxels within `band` of a surface point.
  void measure_free(const kernels::VoxelWindow& window, float band, kernels::SquaredDistances* room) {
    kernels::measure_free(window, band, scale_, room, codes_.data());
  }
  bool is_empty() const;

  mutable std::atomic<bool> was_used{false};  ///< since the cache last looked

 private:
  static std::size_t at(int x, int y, int z) {
    return static_cast<std::size_t>((x + 1) + kSide * ((y + 1) + kSide * (z + 1)));
  }
  float scale_;
  std::array<std::int16_t, kSide * kSide * kSide> codes_;
};

/// Distances near the surfaces of one block, from the surface points and states alone:
///  - free voxels: exact distance of their centre to the nearest surface point within the band;
///  - occupied voxels seen from one side: signed distance to the plane through their surface point, so that the zero
///    level runs through the points that were measured; all others: -(distance to the nearest free centre - half an
///    edge), or minus half an edge where nothing free is beside it and it is not enclosed by occupied voxels;
///  - unknown voxels beside an occupied one: signed distance to its plane. They stay unknown and only serve
///    interpolation inside the known voxels next to them.
/// Exact to float rounding; error of inside values at most half an edge. A function of the field, so it may be
/// forgotten and made again. Measured distances of a projective field are copied instead.
/// Source: docs/maths/submaps.md, "Distances near surfaces".
/// @return null when there is no distance in the block  @complexity O(leaves around * band^3)
std::shared_ptr<const DistanceBlock> derive_distances(const CompressedField& field, const geometry::Index3& block);

}  // namespace voxnav::submap
