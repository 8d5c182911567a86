// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

#include "planning/cell_costs.hpp"
#include "planning/moves.hpp"

namespace voxnav::planning {

/// Refers to a cell of a search by the number of its block in the search space and the offset in that block.
struct CellRef {
  std::uint32_t block = 0;
  std::uint16_t offset = 0;
};

constexpr std::uint64_t kUnreached = std::numeric_limits<std::uint64_t>::max();
/// The cells of a search with their costs and search nodes, in blocks that are created when first touched. The memory
/// of the blocks is bounded.
class SearchSpace {
 public:
  struct Block {
    geometry::Index3 index;
    std::array<std::int64_t, kNumMoves> neighbours;  ///< numbers of the blocks one move away, kUnresolved or kRefused
    CostBlock costs;
    std::array<std::uint64_t, geometry::kBlockVolume> g;
    std::array<std::uint8_t, geometry::kBlockVolume> arrived_by;  ///< move that led to the cell, with kClosed OR-ed in
  };
  static constexpr std::uint8_t kClosed = 0x80;

  /// @param max_bytes  memory of all blocks; a block beyond it is refused, and its cells cannot be entered
  SearchSpace(CellCosts* costs, std::uint64_t max_bytes);

  /// Finds the cell of a voxel; returns false if its block was refused for lack of memory.
  bool locate(const geometry::Index3& voxel, CellRef* out);
  geometry::Index3 voxel(CellRef cell) const;
  Block& block(CellRef cell) { return *blocks_[cell.block]; }
  CellCost cost(CellRef cell) const { return blocks_[cell.block]->costs[cell.offset]; }
  /// Finds the cell one move away; returns false if its block was refused for lack of memory.
  bool step(CellRef from, int move, CellRef* out);

  bool has_refused() const { return has_refused_; }
  std::uint64_t memory_bytes() const { return blocks_.size() * sizeof(Block) + costs_->memory_bytes(); }

 private:
  static constexpr std::int64_t kUnresolved = -1;
  static constexpr std::int64_t kRefused = -2;

  std::int64_t number_of(const geometry::Index3& index);

  CellCosts* costs_;
  std::uint64_t max_bytes_;
  bool has_refused_ = false;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::unordered_map<geometry::Index3, std::uint32_t, geometry::Index3Hash> numbers_;
};

}  // namespace voxnav::planning
