// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

#include "containers/number_table.hpp"
#include "submap/content/block_cells.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/submap/column_block.hpp"

namespace voxnav::submap {

/// The states of one cell, with one bit for each voxel.
struct CellStates {
  std::uint64_t free = 0;
  std::uint64_t occupied = 0;
  std::uint64_t observed_free = 0;  ///< free voxels that the submap observed; the other free ones are remembered
};

/// The states of a submap's voxels, packed block by block. A cell has a word for its occupied voxels if there are any,
/// and a word for its free voxels if some, but not all, of the other voxels are free. Blocks are sorted by index; the
/// position of a block is its place in this order, from 0 on. Occupied voxels are numbered in the order of blocks,
/// cells and voxels. Immutable, hence thread-safe.
class BlockStates {
 public:
  struct Parts;
  BlockStates() = default;
  /// Takes parts that fit each other, as BlockStatesBuilder makes them.
  explicit BlockStates(Parts parts) { take(std::move(parts)); }

  std::size_t size() const { return blocks_.size(); }
  const geometry::Index3& index(std::size_t position) const { return blocks_[position].index; }
  /// Returns the position of a block, or nothing if the whole block is unknown.
  std::optional<std::size_t> find(const geometry::Index3& block) const {
    return table_.find(block, [this](std::uint32_t position) { return index(position); });
  }

  containers::VoxelState state(const geometry::Index3& voxel) const;
  containers::VoxelState state(std::size_t position, int offset) const;
  /// Returns the states of a block as columns.
  ColumnBlock columns(std::size_t position) const;
  /// Returns the free voxels of a block that the submap observed.
  Columns observed_free(std::size_t position) const;
  /// Returns true if observed_free() of a block is not empty.
  bool has_observed_free(std::size_t position) const {
    return (blocks_[position].observed_cells | blocks_[position].partly_observed_cells) != 0;
  }
  /// Returns true if the submap observed all of its free voxels.
  bool is_all_free_observed() const;

  bool has_occupied(std::size_t position) const { return blocks_[position].occupied_cells != 0; }
  std::size_t num_occupied() const { return num_occupied_; }
  /// Number of the first occupied voxel of a block; `position` may be size().
  std::size_t first_number(std::size_t position) const {
    return position < blocks_.size() ? blocks_[position].first_number : num_occupied_;
  }
  /// Calls f(offset, number) for every occupied voxel of a block.
  template <class F>
  void for_each_occupied(std::size_t position, F&& f) const;
  /// Calls f(cell, occupied, first) for every cell of a block that has occupied voxels: `occupied` has a bit for each
  /// voxel, and `first` is the number of the first occupied one.
  template <class F>
  void for_each_occupied_cell(std::size_t position, F&& f) const;
  /// Calls f(cell, free, occupied, first) for every requested cell of a block that is not all unknown; `first` is the
  /// number of the first occupied voxel if there is one.
  /// @param cells  requested cells, one bit for each
  template <class F>
  void for_each_known_cell(std::size_t position, std::uint64_t cells, F&& f) const;
  /// Calls f(cell, states) for every cell of a block that is not all unknown.
  template <class F>
  void for_each_cell(std::size_t position, F&& f) const;

  std::size_t memory_bytes() const;

  /// The cells of one block, with one bit for each cell.
  struct Block {
    geometry::Index3 index;
    // Where the words and the numbers of this block begin in the lists of all blocks.
    std::uint32_t first_occupied = 0;         ///< first word of a cell with occupied voxels
    std::uint32_t first_mixed = 0;            ///< first word of a cell with some free voxels
    std::uint32_t first_partly_observed = 0;  ///< first word of a cell with some observed free voxels
    std::uint32_t first_number = 0;           ///< number of the first occupied voxel
    std::uint64_t occupied_cells = 0;         ///< cells with occupied voxels
    std::uint64_t open_cells = 0;             ///< cells of which all voxels that are not occupied are free
    std::uint64_t mixed_cells = 0;            ///< cells of which some of the voxels that are not occupied are free
    std::uint64_t observed_cells = 0;         ///< cells of which the submap observed all free voxels
    std::uint64_t partly_observed_cells = 0;  ///< cells of which the submap observed some of the free voxels
  };
  /// The serialised parts. The fields `first_*`, and all else that follows from the words, are computed by assign().
  struct Parts {
    std::vector<Block> blocks;
    std::vector<std::uint64_t> occupied;       ///< word of each cell with occupied voxels
    std::vector<std::uint64_t> mixed;          ///< word of the free voxels of each cell with some
    std::vector<std::uint64_t> observed_free;  ///< word of the observed free voxels of each cell with some
  };
  /// Takes parts that were read. Returns null if they fit each other, else what is wrong with them.
  const char* assign(Parts parts);
  const std::vector<Block>& blocks() const { return blocks_; }
  const std::vector<std::uint64_t>& occupied_words() const { return occupied_; }
  const std::vector<std::uint64_t>& mixed_words() const { return mixed_; }
  const std::vector<std::uint64_t>& observed_words() const { return observed_free_; }

 private:
  std::uint64_t occupied_of(const Block& block, int cell) const {
    return has_bit(block.occupied_cells, cell) ? occupied_[block.first_occupied + rank_of(block.occupied_cells, cell)]
                                               : 0;
  }
  std::uint64_t free_of(const Block& block, int cell) const {
    if (has_bit(block.mixed_cells, cell)) return mixed_[block.first_mixed + rank_of(block.mixed_cells, cell)];
    return has_bit(block.open_cells, cell) ? ~occupied_of(block, cell) : 0;
  }
  std::uint64_t observed_free_of(const Block& block, int cell) const {
    if (!has_bit(block.partly_observed_cells, cell))
      return has_bit(block.observed_cells, cell) ? free_of(block, cell) : 0;
    return observed_free_[block.first_partly_observed + rank_of(block.partly_observed_cells, cell)];
  }
  const char* problem_of(const Block& block) const;
  void take(Parts parts);

  std::vector<Block> blocks_;
  std::vector<std::uint64_t> occupied_;
  std::vector<std::uint16_t> numbers_;  ///< for each of these cells: number of occupied voxels before it in its block
  std::vector<std::uint64_t> mixed_;
  std::vector<std::uint64_t> observed_free_;
  std::size_t num_occupied_ = 0;
  containers::NumberTable<geometry::Index3, geometry::Index3Hash> table_;  ///< positions by index
};

template <class F>
void BlockStates::for_each_occupied_cell(std::size_t position, F&& f) const {
  const Block& block = blocks_[position];
  std::size_t word = block.first_occupied;
  kernels::for_each_bit(block.occupied_cells, [&](int cell) {
    f(cell, occupied_[word], std::size_t{block.first_number} + numbers_[word]);
    ++word;
  });
}

template <class F>
void BlockStates::for_each_occupied(std::size_t position, F&& f) const {
  for_each_occupied_cell(position, [&](int cell, std::uint64_t occupied, std::size_t number) {
    kernels::for_each_bit(occupied, [&](int voxel) { f(offset_of(cell, voxel), number++); });
  });
}

template <class F>
void BlockStates::for_each_known_cell(std::size_t position, std::uint64_t cells, F&& f) const {
  const Block& block = blocks_[position];
  kernels::for_each_bit(cells & (block.occupied_cells | block.open_cells | block.mixed_cells), [&](int cell) {
    if (!has_bit(block.occupied_cells, cell)) return f(cell, free_of(block, cell), std::uint64_t{0}, std::size_t{0});
    const std::size_t word = block.first_occupied + rank_of(block.occupied_cells, cell);
    f(cell, free_of(block, cell), occupied_[word], std::size_t{block.first_number} + numbers_[word]);
  });
}

template <class F>
void BlockStates::for_each_cell(std::size_t position, F&& f) const {
  const Block& block = blocks_[position];
  kernels::for_each_bit(block.occupied_cells | block.open_cells | block.mixed_cells, [&](int cell) {
    f(cell, CellStates{free_of(block, cell), occupied_of(block, cell), observed_free_of(block, cell)});
  });
}

}  // namespace voxnav::submap
