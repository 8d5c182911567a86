// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "voxnav/base/bytes.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/submap/column_block.hpp"
#include "voxnav/submap/field_block.hpp"

namespace voxnav::submap {

/// Frozen three-state grid with distances near surfaces. Blocks of 16^3 voxels are made of cells of 4^3; a cell
/// is one tag (all unknown, all free and far from everything), two bits per voxel, or two bits and one byte of
/// distance per voxel. Every occupied voxel keeps its surface point. All lengths are in voxel edges, frame G.
/// Queries read the compressed form; immutable, so thread-safe.
class CompressedField {
 public:
  struct Leaf {
    std::array<std::int8_t, 3> mean;  ///< from the voxel centre, unit voxel edge / 254
    std::uint8_t hits;
  };
  struct Nearest {
    geometry::Vec3 point;
    double squared = 0.0;
  };
  enum class Target { kSurfacePoint, kVoxelCube };

  CompressedField() = default;
  /// @param blocks sorted by index
  /// @param band   distances above it are dropped (they are searched on demand)
  CompressedField(const std::vector<FilledBlock>& blocks, double band);

  containers::State state(const geometry::Index3& voxel) const;
  /// Stored distances at the 2^3 voxels from `lower` on, x fastest; false when one of them has none.
  bool corners(const geometry::Index3& lower, std::array<float, 8>* values) const;
  /// Distance stored at one voxel.
  std::optional<float> value(const geometry::Index3& voxel) const;
  /// Nearest occupied thing within `max_distance` of p, exact. O(blocks within reach).
  std::optional<Nearest> nearest(const geometry::Vec3& p, double max_distance, Target target) const;

  /// Calls f(voxel, leaf) for every occupied voxel, in block and cell order.
  template <class F>
  void for_each_leaf(F&& f) const;
  /// Calls f(voxel, leaf) for the occupied voxels of the block with this index, if there is one.
  template <class F>
  void for_each_leaf_in(const geometry::Index3& index, F&& f) const;

  /// Calls f(voxel) for every voxel of a cell with stored distances.
  template <class F>
  void for_each_value(F&& f) const;

  /// Looks states up, remembering the last block: for walks through neighbouring voxels.
  class Reader {
   public:
    explicit Reader(const CompressedField& field) : field_(&field) {}
    containers::State state(const geometry::Index3& voxel);

   private:
    const CompressedField* field_;
    geometry::Index3 at_{1 << 30, 0, 0};
    const void* block_ = nullptr;
  };

  std::size_t num_blocks() const { return blocks_.size(); }
  const geometry::Index3& block_index(std::size_t i) const { return blocks_[i].index; }
  /// Position of a block among them, -1 when it is not there.
  int position_of(const geometry::Index3& block) const;
  /// States of the i-th block as columns.
  ColumnBlock columns(std::size_t i) const;
  std::size_t num_leaves() const { return leaves_.size(); }
  double band() const { return band_; }
  std::size_t memory_bytes() const;

  void write(base::ByteWriter* out) const;
  /// @throws std::invalid_argument when the parts do not fit each other
  static CompressedField read(base::ByteReader* in);

  /// Cells of a block, and voxels of a cell, x fastest.
  static int cell_of(int offset) { return ((offset >> 2) & 3) | ((offset >> 4) & 12) | ((offset >> 6) & 48); }
  static int voxel_in_cell(int offset) { return (offset & 3) | ((offset >> 2) & 12) | ((offset >> 4) & 48); }
  static int offset_of(int cell, int voxel) {
    return ((cell & 3) << 2) | (voxel & 3) | ((((cell >> 2) & 3) << 2 | ((voxel >> 2) & 3)) << 4) |
           (((cell >> 4) << 2 | (voxel >> 4)) << 8);
  }

 private:
  static constexpr int kCells = 64;
  static constexpr std::uint8_t kAllUnknown = 0;
  static constexpr std::uint8_t kAllFree = 1;
  static constexpr std::uint8_t kFirstStates = 2;         ///< code - kFirstStates: states record of the block
  static constexpr std::uint8_t kFirstNear = 2 + kCells;  ///< code - kFirstNear: near record of the block
  static constexpr std::uint8_t kEndCode = 2 + 2 * kCells;
  static constexpr std::int8_t kNoValue = -128;

  using CellStates = std::array<std::uint64_t, 2>;
  struct NearCell {
    CellStates states;
    std::array<std::int8_t, kCells> values;
    std::uint32_t first_leaf;
  };
  struct Block {
    geometry::Index3 index;
    std::array<std::uint8_t, kCells> codes{};
    std::uint32_t first_states = 0;
    std::uint32_t first_near = 0;
    std::uint64_t occupied_cells = 0;
  };

  template <class F>
  void for_each_leaf_of(const Block& block, F&& f) const;
  containers::State state_in_block(const Block& block, int offset) const;
  void add_block(const FilledBlock& filled);
  void add_cell(const FilledBlock& filled, int cell, Block* block);
  void add_leaves(const FilledBlock& filled, int cell);
  void link();
  const Block* find(const geometry::Index3& index) const;
  std::int8_t code_at(const Block& block, int offset) const;
  void search_block(const Block& block, const geometry::Vec3& p, Target target, Nearest* best) const;
  void place_records(const base::ByteReader& in);
  void check(const base::ByteReader& in) const;
  static int count_occupied(const CellStates& states);

  double band_ = 3.0;
  std::vector<Block> blocks_;
  std::vector<CellStates> states_;
  std::vector<NearCell> near_;
  std::vector<Leaf> leaves_;
  std::vector<std::int32_t> table_;  ///< open addressing: position in blocks_ or -1
};

/// Surface point of a leaf in voxel edges.
inline geometry::Vec3 surface_point(const geometry::Index3& voxel, const CompressedField::Leaf& leaf) {
  return {voxel.x + 0.5 + leaf.mean[0] / 254.0, voxel.y + 0.5 + leaf.mean[1] / 254.0,
          voxel.z + 0.5 + leaf.mean[2] / 254.0};
}

template <class F>
void CompressedField::for_each_leaf_of(const Block& block, F&& f) const {
  for (std::uint64_t cells = block.occupied_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    const NearCell& near = near_[block.first_near + block.codes[cell] - kFirstNear];
    std::uint32_t leaf = near.first_leaf;
    for (int word = 0; word < 2; ++word) {
      for (std::uint64_t occupied = near.states[word] & 0xAAAAAAAAAAAAAAAAull; occupied != 0;
           occupied &= occupied - 1) {
        const int voxel = 32 * word + (__builtin_ctzll(occupied) >> 1);
        f(geometry::voxel_at(block.index, offset_of(cell, voxel)), leaves_[leaf++]);
      }
    }
  }
}

template <class F>
void CompressedField::for_each_leaf(F&& f) const {
  for (const Block& block : blocks_) for_each_leaf_of(block, f);
}

template <class F>
void CompressedField::for_each_leaf_in(const geometry::Index3& index, F&& f) const {
  const Block* block = find(index);
  if (block) for_each_leaf_of(*block, f);
}

template <class F>
void CompressedField::for_each_value(F&& f) const {
  for (const Block& block : blocks_) {
    for (int cell = 0; cell < kCells; ++cell) {
      if (block.codes[cell] < kFirstNear) continue;
      for (int voxel = 0; voxel < kCells; ++voxel) f(geometry::voxel_at(block.index, offset_of(cell, voxel)));
    }
  }
}

}  // namespace voxnav::submap
