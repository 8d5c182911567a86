// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/aabb.hpp"
#include "voxnav/geometry/voxel.hpp"

namespace voxnav::planning {

using containers::StateBlock;
using containers::VoxelState;

struct Sightings;
class Fences;

/// One bit for each voxel of a block, in the order of geometry::offset_in_block(). Unlike std::bitset it shows its
/// words, so that many voxels are looked at at once.
class BlockMask {
 public:
  static constexpr std::size_t kNumWords = geometry::kBlockVolume / 64;

  bool operator[](std::size_t offset) const { return (words_[offset / 64] >> (offset % 64) & 1u) != 0; }
  void set(std::size_t offset) { words_[offset / 64] |= std::uint64_t{1} << (offset % 64); }
  void reset(std::size_t offset) { words_[offset / 64] &= ~(std::uint64_t{1} << (offset % 64)); }
  /// Sets all bits.
  void set() { words_.fill(~std::uint64_t{0}); }
  /// Sets the bits of a layer of voxels, all of the same height in the block.
  void set_layer(int z) {
    const auto first = words_.begin() + static_cast<std::ptrdiff_t>(z) * kWordsPerLayer;
    std::fill(first, first + kWordsPerLayer, ~std::uint64_t{0});
  }

  bool any() const { return !none(); }
  bool none() const { return are_all(0); }
  bool all() const { return are_all(~std::uint64_t{0}); }
  BlockMask& operator|=(const BlockMask& other) {
    for (std::size_t i = 0; i < kNumWords; ++i) words_[i] |= other.words_[i];
    return *this;
  }
  /// Bit i of word w is that of the voxel at offset 64 w + i.
  const std::array<std::uint64_t, kNumWords>& words() const { return words_; }

 private:
  static constexpr int kWordsPerLayer = geometry::kBlockSide * geometry::kBlockSide / 64;

  bool are_all(std::uint64_t value) const {
    return std::all_of(words_.begin(), words_.end(), [value](std::uint64_t word) { return word == value; });
  }

  std::array<std::uint64_t, kNumWords> words_{};
};

/// The interface through which planning reads a map: free, unknown and occupied voxels on one grid (voxel i covers
/// [i, i + 1) * resolution in the view's frame). An implementation does not change while a planner uses it, or it is a
/// snapshot; const calls may come from several threads.
class OccupancyView {
 public:
  virtual ~OccupancyView() = default;

  virtual double resolution_m() const = 0;

  /// Returns the state of a voxel, which is kUnknown outside the map. Never throws.
  virtual VoxelState state(const geometry::Index3& voxel) const = 0;

  /// The box that a path may use. It may be larger than the known part of the map.
  virtual geometry::Aabb bounds() const = 0;

  /// Returns the states of one block of 16^3 voxels, as a pointer to the view's own storage or to the filled `scratch`;
  /// null if the whole block is unknown. The default implementation asks state() for each voxel.
  virtual const StateBlock* block(const geometry::Index3& block, StateBlock* scratch) const;

  /// Returns the blocks that may hold anything but unknown voxels, or voxels that may not be entered for other reasons
  /// than the bounds; in any order, possibly twice. The default implementation returns all blocks of the bounds.
  /// @throws std::length_error from the default implementation if those are too many to be listed
  virtual std::vector<geometry::Index3> known_blocks() const;

  /// ORs the voxels that may not be entered although they are not occupied into the masks: obstacles of another map
  /// that were grown already, or limits of the flight area. A `soft` voxel may be entered where this view itself knows
  /// all voxels within the safety distance, a `hard` one never. The default implementation has none.
  /// @return false if the block has none
  virtual bool forbidden(const geometry::Index3& block, BlockMask* hard, BlockMask* soft) const;

  /// What the newest sweep showed beside the map; null if nothing tells. It is kept as long as the view.
  virtual const Sightings* sightings() const { return nullptr; }

  /// The distance [m] by which the occupied voxels of this view have been grown already. A planner grows them only by
  /// the rest of its safety distance.
  virtual double grown_by_m() const { return 0.0; }

  /// The fences of the flight in the view's frame; null if there are none. forbidden() holds the voxels that paths may
  /// not enter because of them, with a margin; these are exact.
  virtual std::shared_ptr<const Fences> fences() const { return nullptr; }
};

/// Adapts a StateGrid to the interface of planning. Its bounds are the box of the grid's blocks.
class StateGridView : public OccupancyView {
 public:
  /// @param grid        grid, not null, which must not change while the view is in use
  /// @param grown_by_m  distance by which the occupied voxels of the grid have been grown already
  explicit StateGridView(std::shared_ptr<const containers::StateGrid> grid, double grown_by_m = 0.0);

  double resolution_m() const override { return grid_->resolution_m(); }
  VoxelState state(const geometry::Index3& voxel) const override { return grid_->state(voxel); }
  geometry::Aabb bounds() const override { return bounds_; }
  const StateBlock* block(const geometry::Index3& block, StateBlock*) const override {
    return grid_->find_block(block);
  }
  std::vector<geometry::Index3> known_blocks() const override { return grid_->sorted_block_indices(); }
  double grown_by_m() const override { return grown_by_m_; }

 private:
  std::shared_ptr<const containers::StateGrid> grid_;
  double grown_by_m_;
  geometry::Aabb bounds_;
};

/// Returns the box of all blocks of a grid; empty if it has none.
geometry::Aabb bounds_of(const containers::StateGrid& grid);

}  // namespace voxnav::planning
