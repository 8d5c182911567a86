// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "voxnav/occupancy/surface_leaves.hpp"

namespace voxnav::occupancy {

/// One voxel in which beams of the present scan ended.
struct HitVoxel {
  std::uint32_t slot;    ///< of the block in the window
  std::uint16_t offset;  ///< in the block
  PointSpread points;    ///< the end points
};

/// Sorts the beams of one scan into their end voxels, so that each voxel is hit once and one ray is cast for it.
/// Coordinates are voxel edges from the corner of the window.
class EndVoxels {
 public:
  EndVoxels(std::array<int, 3> num_blocks);

  void clear();
  /// `end` must lie inside the window.
  void add_hit(const geometry::Vec3f& end);
  /// A beam that went on behind `end`. The first one in a voxel is kept.
  void add_clearing(const geometry::Vec3f& end);
  /// Call once after the last add. Hits come grouped by block, in the order in which blocks were first hit.
  void finish();

  const std::vector<HitVoxel>& hits() const { return hits_; }
  const std::vector<geometry::Vec3f>& clearing_ends() const { return clearing_ends_; }
  /// Null when nothing ended in the block.
  const VoxelBits* hit_bits(std::uint32_t slot) const {
    return index_[slot] < 0 ? nullptr : &blocks_[index_[slot]].hits;
  }
  struct Range {
    std::size_t begin;
    std::size_t end;
  };
  /// Where the hits of a block lie in hits(); may be empty.
  Range range(std::uint32_t slot) const;
  geometry::Vec3f center_of(const HitVoxel& hit) const;
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
    std::uint32_t block;  ///< in blocks_
    std::uint32_t offset;
  };
  struct Sum {
    geometry::Vec3f offset = geometry::Vec3f::Zero();
    std::array<float, 6> product{};
    int count = 0;
    void add(const geometry::Vec3f& from_center);
    void add(const Sum& other);
  };
  /// Neighbouring beams mostly end in one voxel, so runs of them are summed before the voxel is looked up.
  struct EndRun {
    geometry::Index3 voxel;
    Address address;
    Sum sum;
  };
  static PointSpread spread_of(const Sum& sum);
  Address address_of(int x, int y, int z);
  std::size_t count_hits();

  std::array<int, 3> num_blocks_;
  std::vector<std::int32_t> index_;  ///< of a slot in blocks_, -1 = none
  std::vector<Block> blocks_;
  std::vector<EndRun> runs_;
  std::vector<Sum> sums_;
  std::vector<HitVoxel> hits_;
  std::vector<geometry::Vec3f> clearing_ends_;
};

}  // namespace voxnav::occupancy
