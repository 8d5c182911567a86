// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "base/bytes.hpp"
#include "kernels/bits.hpp"
#include "submap/content/column_block.hpp"
#include "submap/projective/field_block.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::submap {

/// Frozen three-state grid with a surface point in every occupied voxel. Blocks of 16^3 voxels are made of cells of
/// 4^3. A cell keeps a word of its occupied voxels if there are any, and one of its free voxels unless none or all of
/// the others are; a bit per voxel, x fastest. Nothing else is kept: near surfaces the
/// distances follow from the surface points (distance_block.hpp), so that keeping them too would only cost memory.
/// Fields whose distances were measured (projective filling) keep one byte per voxel of the cells near surfaces.
/// All lengths are in voxel edges, frame G. Queries read the compressed form; immutable, so thread-safe.
class CompressedField {
 public:
  struct Leaf {
    std::array<std::int8_t, 3> mean;  ///< from the voxel centre, unit voxel edge / 254
    std::uint8_t hits;
    friend bool operator==(const Leaf& a, const Leaf& b) { return a.mean == b.mean && a.hits == b.hits; }
  };
  struct Nearest {
    geometry::Vec3 point;
    double squared = 0.0;
  };
  enum class Target { kSurfacePoint, kVoxelCube };
  static constexpr std::uint8_t kUnknownTime = 128;  ///< of a leaf: the middle of the submap

  CompressedField() = default;
  /// What a local map handed over; distances are derived. O(blocks + leaves).
  /// @throws std::invalid_argument when leaves and states of the content do not match
  CompressedField(const occupancy::MapContent& content, double band);
  /// With measured distances. @param blocks sorted by index  @param band distances above it are dropped
  CompressedField(const std::vector<FilledBlock>& blocks, double band);

  containers::State state(const geometry::Index3& voxel) const;
  /// Voxel of the block at a position (position_of).
  containers::State state(int position, int offset) const {
    return state_in_block(blocks_[static_cast<std::size_t>(position)], offset);
  }
  /// Whether distances are kept rather than derived.
  bool has_values() const { return has_values_; }
  /// Distance kept for one voxel.
  std::optional<float> value(const geometry::Index3& voxel) const;
  /// Nearest occupied thing within `max_distance` of p, exact. O(blocks within reach).
  std::optional<Nearest> nearest(const geometry::Vec3& p, double max_distance, Target target) const;

  /// Calls f(voxel, leaf) for every occupied voxel, in block and cell order.
  template <class F>
  void for_each_leaf(F&& f) const;
  /// Calls f(voxel, leaf, i, time) for every voxel that the submap hit itself, with the mean of its own hits; i: number
  /// of the voxel among those of for_each_leaf(); time: when it was hit, 0 to 255 from the submap's beginning to its
  /// end.
  template <class F>
  void for_each_own_leaf(F&& f) const;
  /// The same for one block, the i-th: f(offset, leaf, n) with the offset of the voxel and n of all leaves, and time
  /// for own ones.
  template <class F>
  void for_each_leaf_of(std::size_t i, F&& f) const {
    for_each_leaf_of(blocks_[i], f);
  }
  template <class F>
  void for_each_own_leaf_of(std::size_t i, F&& f) const;
  /// Calls f(voxel, leaf) for the occupied voxels of the block with this index, if there is one.
  template <class F>
  void for_each_leaf_in(const geometry::Index3& index, F&& f) const;

  /// Calls f(cell, free, occupied, leaves) for every cell of a block that is not all unknown, with a bit per voxel;
  /// leaves: of its occupied voxels in order, null when there is none. @param cells bit per cell: those asked for
  template <class F>
  void for_each_cell(int position, std::uint64_t cells, F&& f) const;
  /// Whether a block has surface points or measured distances.
  bool has_surface(int position) const { return blocks_[static_cast<std::size_t>(position)].near_cells != 0; }

  std::size_t num_blocks() const { return blocks_.size(); }
  const geometry::Index3& block_index(std::size_t i) const { return blocks_[i].index; }
  /// Position of a block among them, -1 when it is not there.
  int position_of(const geometry::Index3& block) const;
  /// States of the i-th block as columns.
  ColumnBlock columns(std::size_t i) const;
  /// Free voxels of the i-th block that the submap looked at itself; all of them where distances were measured.
  Columns own_free(std::size_t i) const;
  /// Whether the submap saw anything of the i-th block itself.
  bool has_own(std::size_t i) const { return blocks_[i].has_own; }
  /// Whether it holds anything that the submap did not see itself.
  bool has_memory() const;
  std::size_t num_leaves() const { return leaves_.size(); }
  std::size_t num_own_leaves() const { return has_values_ ? leaves_.size() : own_times_.size(); }
  /// Only what the submap saw itself: voxels it merely remembered are unknown, the others hold the mean of its own
  /// hits. Measured fields (has_values) remember nothing, so they are returned as they are. O(size).
  CompressedField own_surface() const;
  /// Gives every surface point of an own surface another place in its voxel: f(voxel, leaf, time) returns it from the
  /// voxel centre, in edges; what lies outside is drawn in.
  template <class F>
  void move_points(F&& f);
  /// When a leaf of an own surface was seen, as a share of the submap's time; one half where that is not known.
  float phase_of(const Leaf* leaf) const {
    const bool is_known = own_times_.size() == leaves_.size();
    return is_known ? static_cast<float>(own_times_[static_cast<std::size_t>(leaf - leaves_.data())]) / 255.0f : 0.5f;
  }
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
  static constexpr std::int8_t kNoValue = -128;

  using CellValues = std::array<std::int8_t, kCells>;
  struct Block {
    geometry::Index3 index;
    // Of its cells among those of all blocks.
    std::uint32_t first_near = 0;
    std::uint32_t first_free = 0;
    std::uint32_t first_leaf = 0;
    std::uint32_t first_own_free = 0;
    bool has_own = false;
    // Bit per cell: has a word of occupied voxels (and measured distances); all others are free; has a word of free
    // voxels.
    std::uint64_t near_cells = 0;
    std::uint64_t open_cells = 0;
    std::uint64_t mixed_cells = 0;
    // Bit per cell: the submap saw all of its free voxels itself, or those that own_free_ has a word for.
    std::uint64_t own_cells = 0;
    std::uint64_t partly_own_cells = 0;
  };

  template <class F>
  void for_each_leaf_of(const Block& block, F&& f) const;
  containers::State state_in_block(const Block& block, int offset) const;
  Block new_block(const geometry::Index3& index) const;
  void add_block(const occupancy::ContentBlock& content);
  void add_block(const FilledBlock& filled);
  void add_leaf(const Leaf& leaf, const Leaf& own, std::uint8_t own_time);
  void add_own_free(int cell, std::uint64_t own, std::uint64_t free, Block* block);
  void add_cell(int cell, std::uint64_t free, std::uint64_t occupied, const CellValues* values, Block* block);
  bool is_own(std::size_t leaf) const { return (own_bits_[leaf >> 6] >> (leaf & 63)) & 1u; }
  bool is_changed(std::size_t own) const { return (changed_bits_[own >> 6] >> (own & 63)) & 1u; }
  /// Own leaves one after another, from the first one at or behind a leaf on.
  struct OwnPlace {
    std::size_t own, changed;
  };
  OwnPlace own_place(std::size_t leaf) const;
  const Leaf& next_own(std::size_t leaf, OwnPlace* place) const {
    return is_changed(place->own++) ? own_leaves_[place->changed++] : leaves_[leaf];
  }
  bool has_own_leaf(const Block& block, std::size_t num_leaves) const;
  static std::vector<std::uint32_t> counts_before(const std::vector<std::uint64_t>& words);
  static std::uint64_t bits_of_cell(const occupancy::VoxelBits& bits, int cell);
  void shrink();
  void link();
  const Block* find(const geometry::Index3& index) const;
  void search_near_block(const Block& block, const geometry::Vec3& p, Target target, Nearest* best) const;
  void search_block(const Block& block, const geometry::Vec3& p, Target target, Nearest* best) const;
  void read_blocks(base::ByteReader* in);
  void read_values(base::ByteReader* in);
  void read_own(base::ByteReader* in);
  void check(const base::ByteReader& in) const;
  void check_own_free(const base::ByteReader& in) const;

  static bool has(std::uint64_t cells, int cell) { return (cells >> cell) & 1u; }
  /// So many of these cells come before a cell.
  static std::size_t rank(std::uint64_t cells, int cell) {
    return kernels::count_bits(cells & ((std::uint64_t{1} << cell) - 1));
  }
  std::size_t near_of(const Block& block, int cell) const { return block.first_near + rank(block.near_cells, cell); }
  std::uint64_t occupied_of(const Block& block, int cell) const {
    return has(block.near_cells, cell) ? occupied_[near_of(block, cell)] : 0;
  }
  std::uint64_t free_of(const Block& block, int cell) const {
    if (has(block.mixed_cells, cell)) return free_[block.first_free + rank(block.mixed_cells, cell)];
    return has(block.open_cells, cell) ? ~occupied_of(block, cell) : 0;
  }
  std::size_t first_leaf_of(const Block& block, std::size_t near) const {
    return block.first_leaf + leaf_offsets_[near];
  }

  double band_ = 3.0;
  bool has_values_ = false;
  std::vector<Block> blocks_;
  std::vector<std::uint64_t> free_;          ///< of mixed cells
  std::vector<std::uint64_t> occupied_;      ///< of cells with surface points or measured distances
  std::vector<std::uint16_t> leaf_offsets_;  ///< of each of them: leaves before it in its block
  std::vector<CellValues> values_;           ///< of each of them, where distances were measured
  std::vector<Leaf> leaves_;
  std::vector<std::uint64_t> own_bits_;  ///< of each leaf: the submap hit it itself; none where distances were measured
  std::vector<std::uint32_t> own_before_;      ///< of each of these words: bits before it
  std::vector<std::uint8_t> own_times_;        ///< when it saw them, 0 to 255 from its beginning to its end
  std::vector<std::uint64_t> changed_bits_;    ///< of each of those: its own hits alone give another leaf
  std::vector<std::uint32_t> changed_before_;  ///< of each of these words: bits before it
  std::vector<Leaf> own_leaves_;               ///< these
  std::vector<std::uint64_t> own_free_;        ///< bit per voxel of cells with own free voxels and remembered ones
  std::vector<std::int32_t> table_;            ///< open addressing: position in blocks_ or -1
};

/// Surface point of a leaf in voxel edges.
inline geometry::Vec3 surface_point(const geometry::Index3& voxel, const CompressedField::Leaf& leaf) {
  return {voxel.x + 0.5 + leaf.mean[0] / 254.0, voxel.y + 0.5 + leaf.mean[1] / 254.0,
          voxel.z + 0.5 + leaf.mean[2] / 254.0};
}

template <class F>
void CompressedField::for_each_leaf_of(const Block& block, F&& f) const {
  std::size_t near = block.first_near;
  std::size_t leaf = block.first_leaf;
  for (std::uint64_t cells = block.near_cells; cells != 0; cells &= cells - 1, ++near) {
    const int cell = __builtin_ctzll(cells);
    for (std::uint64_t occupied = occupied_[near]; occupied != 0; occupied &= occupied - 1, ++leaf) {
      f(offset_of(cell, __builtin_ctzll(occupied)), leaves_[leaf], leaf);
    }
  }
}

template <class F>
void CompressedField::for_each_leaf(F&& f) const {
  for (const Block& block : blocks_) {
    for_each_leaf_of(
        block, [&](int offset, const Leaf& leaf, std::size_t) { f(geometry::voxel_at(block.index, offset), leaf); });
  }
}

template <class F>
void CompressedField::for_each_own_leaf_of(std::size_t i, F&& f) const {
  const Block& block = blocks_[i];
  if (block.near_cells == 0) return;
  if (has_values_) {
    for_each_leaf_of(block, [&](int offset, const Leaf& leaf, std::size_t n) { f(offset, leaf, n, kUnknownTime); });
    return;
  }
  OwnPlace place = own_place(block.first_leaf);
  for_each_leaf_of(block, [&](int offset, const Leaf&, std::size_t leaf) {
    if (!is_own(leaf)) return;
    const std::uint8_t time = own_times_[place.own];
    f(offset, next_own(leaf, &place), leaf, time);
  });
}

template <class F>
void CompressedField::for_each_own_leaf(F&& f) const {
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    for_each_own_leaf_of(i, [&](int offset, const Leaf& leaf, std::size_t n, std::uint8_t time) {
      f(geometry::voxel_at(blocks_[i].index, offset), leaf, n, time);
    });
  }
}

template <class F>
void CompressedField::move_points(F&& f) {
  std::vector<Leaf> moved = leaves_;
  std::size_t i = 0;
  for_each_leaf([&](const geometry::Index3& voxel, const Leaf& leaf) {
    const geometry::Vec3 mean = f(voxel, leaf, own_times_[i]);
    for (int k = 0; k < 3; ++k)
      moved[i].mean[k] = static_cast<std::int8_t>(std::lround(std::min(127.0, std::max(-127.0, mean[k] * 254.0))));
    ++i;
  });
  leaves_ = std::move(moved);  // none of an own surface differs from the leaf of its voxel
}

template <class F>
void CompressedField::for_each_leaf_in(const geometry::Index3& index, F&& f) const {
  const Block* block = find(index);
  if (!block) return;
  for_each_leaf_of(*block,
                   [&](int offset, const Leaf& leaf, std::size_t) { f(geometry::voxel_at(index, offset), leaf); });
}

template <class F>
void CompressedField::for_each_cell(int position, std::uint64_t cells, F&& f) const {
  const Block& block = blocks_[static_cast<std::size_t>(position)];
  for (cells &= block.near_cells | block.open_cells | block.mixed_cells; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    const std::uint64_t occupied = occupied_of(block, cell);
    const Leaf* leaves = occupied != 0 ? &leaves_[first_leaf_of(block, near_of(block, cell))] : nullptr;
    f(cell, free_of(block, cell), occupied, leaves);
  }
}

}  // namespace voxnav::submap
