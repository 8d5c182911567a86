// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "submap/merged/voxel_units.hpp"
#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

/// The surface points of one submap in the blocks of W that they lie in, sorted by columns.
class PlacedPoints {
 public:
  struct Block {
    Columns occupied{};  ///< voxels with points; one may hold several
    /// Of each column, counted in points of all blocks; the last is the end.
    std::array<std::uint32_t, geometry::kBlockSide * geometry::kBlockSide + 1> first{};
    std::uint64_t time_sum = 0;  ///< of its points

    /// When they were seen on average, as a share of the submap's time. There has to be one.
    double phase() const {
      return static_cast<double>(time_sum) / (255.0 * static_cast<double>(first.back() - first.front()));
    }
  };

  /// Add at most `count`, then sort() once. @param num_blocks  an estimate
  void reserve(std::size_t count, std::size_t num_blocks);
  /// The number of a block, new or not.
  std::uint32_t block(const geometry::Index3& index);
  /// The next one, to be filled in and then sorted into its block.
  SurfaceEvidence* next() { return &added_[num_added_]; }
  void add_next(std::uint32_t block, std::uint16_t offset, std::uint8_t time) {
    Block& to = blocks_[block];
    to.time_sum += time;
    const std::size_t column = offset & 255u;
    to.occupied[column] = static_cast<std::uint16_t>(to.occupied[column] | (1u << (offset >> 8)));
    ++to.first[column];
    block_of_added_[num_added_++] = block;
  }
  void sort();

  /// Null when nothing lies there.
  const Block* find(const geometry::Index3& index) const;
  const SurfaceEvidence* begin(const Block& block) const { return points_.data() + block.first.front(); }
  const SurfaceEvidence* end(const Block& block) const { return points_.data() + block.first.back(); }
  /// One block and those around it, each looked up once. No longer than the points live.
  class Around {
   public:
    Around(const PlacedPoints& points, const geometry::Index3& index)
        : points_(&points), index_(index), center_(points.find(index)) {}
    const geometry::Index3& index() const { return index_; }
    /// Null when nothing lies there.
    const Block* center() const { return center_; }
    /// Whether a point lies nearer than `distance` voxel edges to p. @param p  from the corner of the block
    bool has_within(const Units3& p, double distance) const;

   private:
    const Block* at(const geometry::Index3& step) const;

    const PlacedPoints* points_;
    geometry::Index3 index_;
    const Block* center_;
    mutable std::uint32_t looked_up_ = 0;
    mutable std::array<const Block*, 27> near_;
  };

 private:
  bool has_within(const Block& block, const Units3& p, int reach, double squared) const;

  std::unordered_map<geometry::Index3, std::uint32_t, geometry::Index3Hash> numbers_;
  std::vector<Block> blocks_;
  std::size_t num_added_ = 0;
  std::vector<SurfaceEvidence> added_;
  std::vector<std::uint32_t> block_of_added_;
  std::vector<SurfaceEvidence> points_;
};

}  // namespace voxnav::submap
