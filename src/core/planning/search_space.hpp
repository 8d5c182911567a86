// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <unordered_map>
#include <vector>

#include "planning/cell_costs.hpp"

namespace voxnav::planning {

/// A cell of a search: number of its block in the search space, and offset inside.
struct CellRef {
  std::uint32_t block = 0;
  std::uint16_t offset = 0;
};

constexpr std::uint64_t kUnreached = std::numeric_limits<std::uint64_t>::max();
/// Moves 0 to 26: x + 3 y + 9 z of the step plus one on each axis; 13 stands still.
constexpr int kNumMoves = 27;
constexpr int kNoMove = 13;

/// Cells with their costs and search nodes, in blocks made on first touch and bounded in number.
class SearchSpace {
 public:
  struct Block {
    geometry::Index3 index;
    std::array<std::int64_t, kNumMoves> neighbours;  ///< block numbers; kUnresolved or kRefused
    CostBlock costs;
    std::array<std::uint64_t, geometry::kBlockVolume> g;
    std::array<std::uint8_t, geometry::kBlockVolume> arrived_by;  ///< move that led here; kClosed is OR-ed in
  };
  static constexpr std::uint8_t kClosed = 0x80;

  /// @param max_bytes blocks beyond this are refused: their cells cannot be entered
  SearchSpace(CellCosts* costs, std::uint64_t max_bytes);

  /// False when the block was refused for lack of memory.
  bool locate(const geometry::Index3& voxel, CellRef* out);
  geometry::Index3 voxel(CellRef cell) const;
  Block& block(CellRef cell) { return *blocks_[cell.block]; }
  CellCost cost(CellRef cell) const { return blocks_[cell.block]->costs[cell.offset]; }
  /// The cell one move away, or false when its block was refused.
  bool step(CellRef from, int move, CellRef* out);

  bool has_refused() const { return has_refused_; }
  std::uint64_t memory_bytes() const { return blocks_.size() * sizeof(Block) + costs_->memory_bytes(); }

 private:
  static constexpr std::int64_t kUnresolved = -1;
  static constexpr std::int64_t kRefused = -2;

  std::int64_t number_of(const geometry::Index3& block);

  CellCosts* costs_;
  std::uint64_t max_bytes_;
  bool has_refused_ = false;
  std::vector<std::unique_ptr<Block>> blocks_;
  std::unordered_map<geometry::Index3, std::uint32_t, geometry::Index3Hash> numbers_;
};

/// The 26 moves: step, squared length, and the cells of the 3^3 neighbourhood (bits by move number) that it touches.
struct Move {
  geometry::Index3 step;
  int num_axes;
  std::uint32_t touched;
};
const std::array<Move, kNumMoves>& moves();

}  // namespace voxnav::planning
