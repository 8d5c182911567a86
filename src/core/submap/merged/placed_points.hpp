// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "submap/merged/voxel_units.hpp"
#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

/// The surface points of one submap, sorted into the blocks of W and their columns, so that the points around a place
/// are found without searching a whole block. It is filled once and then only read.
class PlacedPoints {
 public:
  struct Block {
    Columns occupied{};  ///< voxels with points; a voxel may hold several
    /// Number of the first point of each column among the points of all blocks; the last entry is the end of the block.
    std::array<std::uint32_t, geometry::kBlockSide * geometry::kBlockSide + 1> first{};
    std::uint64_t time_sum = 0;  ///< sum of the times of the points, 0 to 255 each

    /// Returns the mean phase, 0 to 1, at which the points were seen. Precondition: the block has points.
    double phase() const {
      return static_cast<double>(time_sum) / (255.0 * static_cast<double>(first.back() - first.front()));
    }
  };

  /// Reserves memory. Afterwards at most `count` points may be added, and then sort() is called once.
  /// @param num_blocks  estimated number of blocks
  void reserve(std::size_t count, std::size_t num_blocks);
  /// Returns the number of a block, which is added if it does not exist yet.
  std::uint32_t block(const geometry::Index3& index);
  /// Returns the memory of the next point, to be filled in before add_next().
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

  /// Returns null if no point lies in the block.
  const Block* find(const geometry::Index3& index) const;
  const SurfaceEvidence* begin(const Block& block) const { return points_.data() + block.first.front(); }
  const SurfaceEvidence* end(const Block& block) const { return points_.data() + block.first.back(); }
  /// One block and its 26 neighbours, each of which is looked up at most once. It must not outlive the points.
  class Around {
   public:
    Around(const PlacedPoints& points, const geometry::Index3& index)
        : points_(&points), index_(index), center_(points.find(index)) {}
    const geometry::Index3& index() const { return index_; }
    /// Returns null if no point lies in the block itself.
    const Block* center() const { return center_; }
    /// Returns true if any point lies nearer than `distance` voxel edges to p.
    /// @param p  position relative to the corner of the block
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
