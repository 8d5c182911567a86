// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <bitset>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/aabb.hpp"

namespace voxnav::planning {

using containers::State;
using containers::StateBlock;

/// One bit per voxel of a block, order of geometry::offset_in_block().
using BlockMask = std::bitset<geometry::kBlockVolume>;

/// All that planning may know of a map: three-state voxels on one lattice (voxel i covers [i, i + 1) * resolution
/// in the view's frame). Implementations do not change while a planner uses them, or are snapshots; const calls
/// may come from several threads.
class OccupancyView {
 public:
  virtual ~OccupancyView() = default;

  virtual double resolution_m() const = 0;

  /// Unknown wherever nothing is known; never throws.
  virtual State state(const geometry::Index3& voxel) const = 0;

  /// Box that a path may use; what lies outside is outside the map. May be larger than what is known.
  virtual geometry::Aabb bounds() const = 0;

  /// States of one block of 16^3 voxels: a pointer to the view's own storage or to `scratch`, filled;
  /// null when the whole block is unknown. The default asks state() for each voxel.
  virtual const StateBlock* block(const geometry::Index3& block, StateBlock* scratch) const;

  /// Voxels that may not be entered although they are not occupied (grown obstacles of another map, limits),
  /// OR-ed into the masks. `soft` ones give way where this view itself knows everything within the safety
  /// distance; `hard` ones never do. The default has none.
  /// @return false when the block has none
  virtual bool forbidden(const geometry::Index3& block, BlockMask* hard, BlockMask* soft) const;

  /// How far the occupied voxels of this view have been grown already [m]; planners grow by the rest only.
  virtual double grown_by_m() const { return 0.0; }
};

}  // namespace voxnav::planning
