// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "occupancy/scan_part.hpp"
#include "occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// One voxel in which beams of the present scan ended.
struct HitVoxel {
  std::uint32_t slot;        ///< slot of the block in the window
  std::uint16_t offset;      ///< offset of the voxel in the block
  std::uint16_t num_points;  ///< end points in the voxel, saturates
  PointSpread points;        ///< mean and covariance of the end points
};

/// Sorts the beams of one scan into their end voxels, so that each voxel is hit once and one ray is cast for it.
/// Coordinates are voxel edges from the corner of the window.
class EndVoxels {
 public:
  explicit EndVoxels(std::array<int, 3> num_blocks);

  void clear();
  /// Adds the part of a scan that one thread prepared: its runs of end points, and the beams that were cut, of which
  /// only the first one in each voxel is kept. The caller keeps the part in place until finish().
  void add(const ScanPart& part);
  /// Completes the hits of the scan; to be called once after the last add(). Hits are then grouped by block, in the
  /// order in which blocks were first hit.
  void finish();

  const std::vector<HitVoxel>& hits() const { return hits_; }
  /// The ends of the rays to cast: the mean of each hit voxel's points, in the order of hits(), then the ends of the
  /// beams that were cut.
  const std::vector<geometry::Vec3f>& rays() const { return rays_; }
  /// Adds one more ray that hits nothing.
  void add_ray(const geometry::Vec3f& end) { rays_.push_back(end); }
  /// The voxels of a block that were hit; null when no beam ended in the block.
  const VoxelBits* hit_bits(std::uint32_t slot) const {
    return index_[slot] < 0 ? nullptr : &blocks_[index_[slot]].hits;
  }
  struct Range {
    std::size_t begin;
    std::size_t end;
  };
  /// The range of hits() that lies in a block; it may be empty.
  Range range(std::uint32_t slot) const;
  /// Widens a box of blocks (counted from the window's corner) until it holds all ends.
  void widen(geometry::Index3* low, geometry::Index3* high) const;
  std::size_t memory_bytes() const;

 private:
  struct Block {
    std::uint32_t slot = 0;
    std::uint32_t first_hit = 0;
    VoxelBits hits{};
    VoxelBits clearing{};
    std::array<std::uint16_t, 64> hits_before{};
  };
  struct Address {
    std::uint32_t block;  ///< index into blocks_
    std::uint32_t offset;
  };
  static PointSpread spread_of(const kernels::PointSum& sum);
  Address address_of(const geometry::Index3& voxel);
  void add_clearing(const geometry::Vec3f& end);
  std::size_t count_hits();
  void finish_block(const Block& block);
  geometry::Index3 block_of_slot(std::uint32_t slot) const;

  std::array<int, 3> num_blocks_;
  std::vector<std::int32_t> index_;  ///< index into blocks_ by slot of the window, -1 = no beam ended there
  std::vector<Block> blocks_;
  std::vector<const ScanPart*> parts_;
  std::vector<Address> addresses_;  ///< voxel of each run, over all runs of all parts
  std::vector<kernels::PointSum> sums_;
  std::vector<HitVoxel> hits_;
  std::vector<geometry::Vec3f> clearing_ends_;
  std::vector<geometry::Vec3f> rays_;
};

}  // namespace voxnav::occupancy
