// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "submap/content/block_cells.hpp"

namespace voxnav::submap {

/// The signed distances of a submap that measured them by rays (projective filling), with one byte for each voxel of
/// the cells near surfaces. Submaps made from occupancy have none, since their distances follow from the surface
/// points. Blocks have the same positions as in BlockStates.
class MeasuredDistances {
 public:
  /// The distances of one cell in steps of band / 127; kNone where nothing was measured.
  using Cell = std::array<std::int8_t, kVoxelsOfCell>;
  static constexpr std::int8_t kNone = -128;

  /// @param band  largest distance that is kept, voxel edges
  explicit MeasuredDistances(double band) : band_(band) {}

  /// Returns the distance at the centre of a voxel, voxel edges; nothing if none was measured.
  std::optional<float> at(std::size_t position, int offset) const;

  /// Begins the next block, whose cells are then added in order; to be called for every block in order.
  void begin_block() { blocks_.push_back({0, static_cast<std::uint32_t>(cells_.size())}); }
  void add_cell(int cell, const Cell& distances);
  /// Returns the byte of a distance; kNone if it is beyond the band or not a number.
  std::int8_t code_of(float distance) const;
  void finish();

  /// The serialised parts: for each block a bit for each cell that has distances, and these cells.
  std::vector<std::uint64_t> cells_of_blocks() const;
  const std::vector<Cell>& cells() const { return cells_; }
  /// Takes parts that were read. @return false if they do not fit each other
  bool assign(const std::vector<std::uint64_t>& cells_of_blocks, std::vector<Cell> cells);
  std::size_t memory_bytes() const { return blocks_.capacity() * sizeof(Block) + cells_.capacity() * sizeof(Cell); }

 private:
  struct Block {
    std::uint64_t cells;  ///< cells that have distances, one bit for each
    std::uint32_t first;  ///< index of the first of them in the list of all blocks
  };
  double band_;
  std::vector<Block> blocks_;
  std::vector<Cell> cells_;
};

}  // namespace voxnav::submap
