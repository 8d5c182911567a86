// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "kernels/bits.hpp"
#include "kernels/blend_moments.hpp"
#include "voxnav/geometry/voxel.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::occupancy {

/// Mean and covariance of points, in voxel edges.
struct PointSpread {
  geometry::Vec3f mean = geometry::Vec3f::Zero();  ///< offset of the mean from the voxel centre
  std::array<float, 6> covariance{};               ///< xx xy xz yy yz zz
};

/// The hit statistics of one voxel: mean and covariance of its hits, and counts of the scans that hit it or saw through
/// it.
struct SurfaceLeaf {
  std::array<std::int16_t, 6> covariance{};  ///< xx xy xz yy yz zz; a squared voxel edge = kCovarianceUnits
  std::uint8_t scans = 0;                    ///< scans that hit the voxel, saturates at 255
  std::uint8_t octants = 0;                  ///< octants seen through since the last hit
  std::uint8_t seen_through = 0;             ///< scans that saw through the surface since the last hit
  std::uint8_t patience = 0;                 ///< highest seen_through that a later hit refuted (foliage)
  std::array<std::int16_t, 3> mean{};        ///< offset from the voxel centre; half a voxel edge = kMeanUnits
  // The statistics above decide the state of the voxel and are never reset. Those below count hits since the last
  // handover only: submaps are registered by them, because surfaces that two submaps share as a copy of the same local
  // map say nothing about their relative pose.
  std::array<std::int16_t, 3> recent_mean{};  ///< mean of the recent hits, in the units of `mean`
  std::uint16_t recent_scans = 0;             ///< scans with recent hits, saturates
  std::uint16_t recent_time = 0;              ///< mean number since the handover of those scans; a scan = kTimeUnits

  static constexpr float kMeanUnits = kernels::kMeanUnits;
  static constexpr float kCovarianceUnits = kernels::kCovarianceUnits;
  /// Offset of the mean hit point from the voxel centre, in voxel edges.
  geometry::Vec3f offset() const { return geometry::Vec3f(mean[0], mean[1], mean[2]) * (0.5f / kMeanUnits); }
  /// Adds the hits of one scan. The first kMemory scans weigh equally; from then on old ones fade exponentially, so
  /// that the mean follows a surface that moves.
  /// @param number  number of the scan since the last handover, from 1
  void add_scan(const PointSpread& hits, int number);
  /// Counts a scan that saw through the surface. Returns false, which forgives the miss, while hits have refuted as
  /// many such scans in a row before.
  bool is_refuted_by_seeing_through(int max_patience);
  static constexpr int kMemory = 50;
  static constexpr int kTimeUnits = 16;  ///< units of recent_time per scan; it then holds up to 4095 scans
  static constexpr int kMaxNumber = 65535 / kTimeUnits;
  /// @param num_scans  number of scans since the last handover
  OccupiedVoxel quantised(int offset_in_block, int num_scans) const;

 private:
  void add(const PointSpread& hits, int number);
  void add_plain(const PointSpread& hits, int number);
  void add_wide(const PointSpread& hits, int number);
};

static_assert(sizeof(SurfaceLeaf) == 32, "two registers");

/// The hit statistics of the voxels of one block, packed in voxel order. The statistics of a voxel are found by
/// counting the bits of the voxels before it.
class SurfaceLeaves {
 public:
  const VoxelBits& bits() const { return bits_; }
  bool contains(int offset) const { return ((bits_[offset >> 6] >> (offset & 63)) & 1u) != 0; }
  /// Returns null if the voxel has no hit statistics.
  const SurfaceLeaf* find(int offset) const { return contains(offset) ? &leaves_[rank(offset)] : nullptr; }
  SurfaceLeaf* find(int offset) { return contains(offset) ? &leaves_[rank(offset)] : nullptr; }
  /// Makes exactly the voxels of `bits` hold a leaf: existing leaves are kept, new ones are empty. O(block).
  void assign(const VoxelBits& bits);
  /// Resets the statistics since the last handover. O(leaves).
  void begin_handover();
  bool empty() const { return leaves_.empty(); }
  std::size_t size() const { return leaves_.size(); }
  std::size_t heap_bytes() const { return leaves_.capacity() * sizeof(SurfaceLeaf); }

 private:
  std::size_t rank(int offset) const {
    const std::uint64_t below = (std::uint64_t{1} << (offset & 63)) - 1;
    return first_[offset >> 6] + kernels::count_bits(bits_[offset >> 6] & below);
  }

  VoxelBits bits_{};
  std::array<std::uint16_t, 64> first_{};  ///< number of leaves before each word of bits_
  std::vector<SurfaceLeaf> leaves_;
};

}  // namespace voxnav::occupancy
