// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <mutex>
#include <unordered_map>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::pipeline {

/// The obstacles of the global map, whose voxels are those of frame W, on the voxels of the local map in frame O. Each
/// block is placed when it is first asked for and kept, since the planner compares all blocks each time it plans, while
/// the obstacles and T_W_O change only when submaps are aligned. Thread-safe.
class PlacedObstacles {
 public:
  /// @param grid            obstacles in W, not null
  /// @param resolution_m    edge of the voxels in O
  PlacedObstacles(std::shared_ptr<const containers::StateGrid> grid, const geometry::Pose& T_W_O, double resolution_m)
      : grid_(std::move(grid)), T_W_O_(T_W_O), resolution_m_(resolution_m) {}

  /// ORs the voxels of a block in O whose centres lie in obstacles into a mask. O(voxels of a block) when the block is
  /// first asked for.
  /// @return false if there are none
  bool mask(const geometry::Index3& block, planning::BlockMask* out) const;
  /// Boxes in O around the blocks that hold obstacles.
  std::vector<geometry::Aabb> block_boxes() const;

  bool is_of(const containers::StateGrid* grid, const geometry::Pose& T_W_O, double resolution_m) const {
    return grid == grid_.get() && resolution_m == resolution_m_ && T_W_O.matrix() == T_W_O_.matrix();
  }

 private:
  /// The voxels of a block that lie in obstacles; null if there are none.
  std::unique_ptr<planning::BlockMask> place(const geometry::Index3& block) const;

  std::shared_ptr<const containers::StateGrid> grid_;
  geometry::Pose T_W_O_;
  double resolution_m_;
  mutable std::mutex mutex_;
  mutable std::unordered_map<geometry::Index3, std::unique_ptr<planning::BlockMask>, geometry::Index3Hash> masks_;
};

}  // namespace voxnav::pipeline
