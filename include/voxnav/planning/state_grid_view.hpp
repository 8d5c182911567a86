// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

/// Adapts a StateGrid to the interface of planning. Its bounds are the box of the grid's blocks.
class StateGridView : public OccupancyView {
 public:
  /// @param grid        grid, not null, which must not change while the view is in use
  /// @param grown_by_m  distance by which the occupied voxels of the grid have been grown already
  explicit StateGridView(std::shared_ptr<const containers::StateGrid> grid, double grown_by_m = 0.0);

  double resolution_m() const override { return grid_->resolution_m(); }
  State state(const geometry::Index3& voxel) const override { return grid_->state(voxel); }
  geometry::Aabb bounds() const override { return bounds_; }
  const StateBlock* block(const geometry::Index3& block, StateBlock*) const override {
    return grid_->find_block(block);
  }
  double grown_by_m() const override { return grown_by_m_; }

 private:
  std::shared_ptr<const containers::StateGrid> grid_;
  double grown_by_m_;
  geometry::Aabb bounds_;
};

/// Returns the box of all blocks of a grid; empty if it has none.
geometry::Aabb bounds_of(const containers::StateGrid& grid);

}  // namespace voxnav::planning
