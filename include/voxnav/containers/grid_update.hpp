// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/containers/state_grid.hpp"

namespace voxnav::containers {

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
