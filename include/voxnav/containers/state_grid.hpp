// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::containers {

/// What is known of a voxel. The values are part of the Python face and of messages.
enum class VoxelState : std::uint8_t { kUnknown = 0, kFree = 1, kOccupied = 2 };

/// The states of one block of 16^3 voxels, two bits each, voxel order of geometry::offset_in_block().
struct StateBlock {
  std::array<std::uint64_t, geometry::kBlockVolume / 32> words{};

  VoxelState get(int offset) const { return static_cast<VoxelState>((words[offset >> 5] >> (2 * (offset & 31))) & 3u); }
  void set(int offset, VoxelState state) {
    const int shift = 2 * (offset & 31);
    std::uint64_t& word = words[offset >> 5];
    word = (word & ~(std::uint64_t{3} << shift)) | (static_cast<std::uint64_t>(state) << shift);
  }
  bool all_unknown() const;
};

/// A grid of voxels in three states, in blocks: the form in which occupancy leaves a map for messages, submaps and the
/// planner. Blocks that are not there are unknown. A block takes 1 KiB beside its index. Not thread-safe.
class StateGrid {
 public:
  using Blocks = std::unordered_map<geometry::Index3, StateBlock, geometry::Index3Hash>;

  /// @throws std::invalid_argument unless resolution_m > 0
  explicit StateGrid(double resolution_m);

  double resolution_m() const { return resolution_m_; }
  VoxelState state(const geometry::Index3& voxel) const;
  /// The state of the voxel that holds a point; unknown for points that are not finite.
  VoxelState state(const geometry::Vec3& point) const;
  void set(const geometry::Index3& voxel, VoxelState state);

  const StateBlock* find_block(const geometry::Index3& block) const;
  StateBlock& block(const geometry::Index3& block) { return blocks_[block]; }
  /// A block that holds nothing but unknown is removed.
  void replace_block(const geometry::Index3& block, const StateBlock& states);
  void erase_block(const geometry::Index3& block) { blocks_.erase(block); }
  void clear() { blocks_.clear(); }

  const Blocks& blocks() const { return blocks_; }
  std::vector<geometry::Index3> sorted_block_indices() const;
  std::size_t memory_bytes() const;

 private:
  double resolution_m_;
  Blocks blocks_;
};

/// Changed blocks of a StateGrid, laid out as msg/GridUpdate.msg carries them.
struct GridUpdate {
  bool is_snapshot = false;                         ///< the update replaces everything
  std::vector<std::int32_t> block_indices;          ///< x y z per block
  std::vector<std::uint8_t> states;                 ///< kBytesPerBlock per block: two bits per voxel, x fastest
  std::vector<std::int32_t> removed_block_indices;  ///< x y z per block that is now unknown as a whole

  static constexpr std::size_t kBytesPerBlock = geometry::kBlockVolume / 4;

  void add(const geometry::Index3& block, const StateBlock& states);
  void remove(const geometry::Index3& block);
};

/// An update with everything that the grid holds, its blocks in sorted order.
GridUpdate snapshot_of(const StateGrid& grid);

/// An update with the listed blocks as the grid holds them now; blocks that it does not hold are reported as removed.
GridUpdate changes_of(const StateGrid& grid, const std::vector<geometry::Index3>& blocks);

/// Applies an update; the grid is unchanged when it throws. O(blocks of the update).
/// @throws std::invalid_argument when lengths do not match or a voxel holds a state that does not exist
void apply(const GridUpdate& update, StateGrid* grid);

}  // namespace voxnav::containers
