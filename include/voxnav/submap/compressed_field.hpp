// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <optional>
#include <vector>

#include "voxnav/base/bytes.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/occupancy/map_content.hpp"
#include "voxnav/submap/column_block.hpp"
#include "voxnav/submap/field_block.hpp"

namespace voxnav::submap {

/// Frozen three-state grid with a surface point in every occupied voxel. Blocks of 16^3 voxels are made of cells of
/// 4^3; a cell is one tag (all unknown, all free), or two bits per voxel. Nothing else is kept: near surfaces the
/// distances follow from the surface points (distance_block.hpp), so that keeping them too would only cost memory.
/// Fields whose distances were measured (projective filling) keep one byte per voxel of the cells near surfaces.
/// All lengths are in voxel edges, frame G. Queries read the compressed form; immutable, so thread-safe.
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

  /// Calls f(cell, states, leaves) for every cell of a block that is not all unknown; states: two bits per voxel,
  /// leaves: of its occupied voxels in order, null when there is none. @param cells bit per cell: those asked for
  template <class F>
  void for_each_cell(int position, std::uint64_t cells, F&& f) const;
  /// Whether a block has surface points or measured distances.
  bool has_surface(int position) const {
    const Block& block = blocks_[static_cast<std::size_t>(position)];
    return block.occupied_cells != 0 || (has_values_ && block.num_near > 0);
  }

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
  std::size_t num_leaves() const { return leaves_.size(); }
  std::size_t num_own_leaves() const { return has_values_ ? leaves_.size() : own_leaves_.size(); }
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
  /// What older files did not tell from what was remembered is taken for own.
  enum class OwnParts { kNone, kHits, kHitsAndFree };
  /// @throws std::invalid_argument when the parts do not fit each other
  static CompressedField read(base::ByteReader* in, OwnParts own);

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
  using CellValues = std::array<std::int8_t, kCells>;
  struct Block {
    geometry::Index3 index;
    std::array<std::uint8_t, kCells> codes{};
    std::uint32_t first_states = 0;
    std::uint32_t first_near = 0;
    std::uint64_t occupied_cells = 0;
    std::uint8_t num_near = 0;
    bool has_own = false;
    // Bit per cell: the submap saw all of its free voxels itself, or those that own_free_ has a word for.
    std::uint64_t own_cells = 0;
    std::uint64_t partly_own_cells = 0;
    std::uint32_t first_own_free = 0;
  };

  template <class F>
  void for_each_leaf_of(const Block& block, F&& f) const;
  containers::State state_in_block(const Block& block, int offset) const;
  Block new_block(const geometry::Index3& index) const;
  void add_block(const occupancy::ContentBlock& content);
  void add_block(const FilledBlock& filled);
  void add_leaf(const Leaf& leaf, const Leaf& own, std::uint8_t own_time);
  void add_own_free(int cell, std::uint64_t own, const CellStates& states, Block* block);
  bool is_own(std::size_t leaf) const { return (own_bits_[leaf >> 6] >> (leaf & 63)) & 1u; }
  void read_own(base::ByteReader* in);
  void write_own_free(base::ByteWriter* out) const;
  void read_own_free(base::ByteReader* in);
  void take_all_free();
  bool has_own_leaf(const Block& block) const;
  void add_cell(int cell, const CellStates& states, const CellValues* values, Block* block);
  void shrink();
  void link();
  const Block* find(const geometry::Index3& index) const;
  std::size_t num_own_before(std::size_t leaf) const;
  void search_near_block(const Block& block, const geometry::Vec3& p, Target target, Nearest* best) const;
  void search_block(const Block& block, const geometry::Vec3& p, Target target, Nearest* best) const;
  void place_records(const base::ByteReader& in);
  CellStates cell_states(const Block& block, int cell) const;
  void check(const base::ByteReader& in) const;
  static int count_occupied(const CellStates& states);
  static std::uint64_t free_of(const CellStates& states);
  static std::uint64_t bits_of_cell(const occupancy::VoxelBits& bits, int cell);

  double band_ = 3.0;
  bool has_values_ = false;
  std::vector<Block> blocks_;
  std::vector<CellStates> states_;
  std::vector<CellStates> near_;           ///< cells with surface points or measured distances
  std::vector<std::uint32_t> first_leaf_;  ///< of each of them
  std::vector<CellValues> values_;         ///< of each of them, where distances were measured
  std::vector<Leaf> leaves_;
  std::vector<std::uint64_t> own_bits_;  ///< of each leaf: the submap hit it itself; none where distances were measured
  std::vector<std::uint32_t> own_before_;  ///< of each of these words: bits before it
  std::vector<Leaf> own_leaves_;           ///< for those, from the submap's own hits
  std::vector<std::uint8_t> own_times_;    ///< and when it saw them, 0 to 255 from its beginning to its end
  std::vector<std::uint64_t> own_free_;    ///< bit per voxel of cells with own free voxels and remembered ones
  std::vector<std::int32_t> table_;        ///< open addressing: position in blocks_ or -1
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
    const std::size_t near = block.first_near + block.codes[cell] - kFirstNear;
    std::size_t leaf = first_leaf_[near];
    for (int word = 0; word < 2; ++word) {
      for (std::uint64_t occupied = near_[near][word] & 0xAAAAAAAAAAAAAAAAull; occupied != 0;
           occupied &= occupied - 1, ++leaf) {
        f(offset_of(cell, 32 * word + (__builtin_ctzll(occupied) >> 1)), leaves_[leaf], leaf);
      }
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
  if (block.occupied_cells == 0) return;
  if (has_values_) {
    for_each_leaf_of(block, [&](int offset, const Leaf& leaf, std::size_t n) { f(offset, leaf, n, kUnknownTime); });
    return;
  }
  std::size_t own = num_own_before(first_leaf_[block.first_near]);
  for_each_leaf_of(block, [&](int offset, const Leaf&, std::size_t leaf) {
    if (!is_own(leaf)) return;
    f(offset, own_leaves_[own], leaf, own_times_[own]);
    ++own;
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
  leaves_ = own_leaves_ = std::move(moved);
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
  for (; cells != 0; cells &= cells - 1) {
    const int cell = __builtin_ctzll(cells);
    const std::uint8_t code = block.codes[cell];
    if (code == kAllUnknown) continue;
    const bool has_leaves = (block.occupied_cells >> cell) & 1;
    f(cell, cell_states(block, cell),
      has_leaves ? &leaves_[first_leaf_[block.first_near + code - kFirstNear]] : static_cast<const Leaf*>(nullptr));
  }
}

}  // namespace voxnav::submap
