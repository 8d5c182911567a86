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

/// Mean and spread of points, voxel edges.
struct PointSpread {
  geometry::Vec3f mean = geometry::Vec3f::Zero();  ///< from the voxel centre
  std::array<float, 6> covariance{};               ///< xx xy xz yy yz zz
};

/// What the hits inside one voxel say about the surface.
struct SurfaceLeaf {
  std::array<std::int16_t, 6> covariance{};  ///< xx xy xz yy yz zz; a squared voxel edge = kCovarianceUnits
  std::uint8_t scans = 0;                    ///< scans that hit the voxel, saturates at 255
  std::uint8_t octants = 0;                  ///< octants seen through since the last hit
  std::uint8_t seen_through = 0;             ///< scans that saw through the surface since the last hit
  std::uint8_t patience = 0;                 ///< most of these that a later hit ever refuted: leaves let beams through
  std::array<std::int16_t, 3> mean{};        ///< from the voxel centre; half a voxel edge = kMeanUnits
  // Beside the rest, which decides what is believed and is never reset: hits since the last handover alone. Submaps are
  // registered by these, because what two of them share by copy says nothing about where they lie.
  std::array<std::int16_t, 3> recent_mean{};  ///< as `mean`
  std::uint16_t recent_scans = 0;             ///< saturates
  std::uint16_t recent_time = 0;              ///< mean number of these scans since the handover; a scan = kTimeUnits

  static constexpr float kMeanUnits = kernels::kMeanUnits;
  static constexpr float kCovarianceUnits = kernels::kCovarianceUnits;
  /// Mean hit point from the voxel centre, in voxel edges.
  geometry::Vec3f offset() const { return geometry::Vec3f(mean[0], mean[1], mean[2]) * (0.5f / kMeanUnits); }
  /// Adds one scan's hits. Scans weigh alike up to kMemory of them; after that old ones fade, so that the mean follows
  /// a surface that moves.
  /// @param number  of the scan since the last handover, from 1
  void add_scan(const PointSpread& hits, int number);
  /// A scan saw through the surface. False while hits have refuted as many such scans in a row before.
  bool is_refuted_by_seeing_through(int max_patience);
  static constexpr int kMemory = 50;
  static constexpr int kTimeUnits = 16;  ///< of recent_time, which then holds 4095 scans
  static constexpr int kMaxNumber = 65535 / kTimeUnits;
  /// @param num_scans  since the last handover
  OccupiedVoxel quantised(int offset_in_block, int num_scans) const;

 private:
  void add(const PointSpread& hits, int number);
  void add_plain(const PointSpread& hits, int number);
  void add_wide(const PointSpread& hits, int number);
};

static_assert(sizeof(SurfaceLeaf) == 32, "two registers");

/// The voxels of one block that hold hits, packed in voxel order; found by counting bits.
class SurfaceLeaves {
 public:
  const VoxelBits& bits() const { return bits_; }
  bool contains(int offset) const { return ((bits_[offset >> 6] >> (offset & 63)) & 1u) != 0; }
  /// Null when the voxel holds none.
  const SurfaceLeaf* find(int offset) const { return contains(offset) ? &leaves_[rank(offset)] : nullptr; }
  SurfaceLeaf* find(int offset) { return contains(offset) ? &leaves_[rank(offset)] : nullptr; }
  /// Afterwards exactly the voxels of `bits` hold a leaf: kept where there was one, else empty. O(block).
  void assign(const VoxelBits& bits);
  /// Hits count as recent from here on. O(leaves).
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
  std::array<std::uint16_t, 64> first_{};  ///< leaves before each word
  std::vector<SurfaceLeaf> leaves_;
};

}  // namespace voxnav::occupancy
