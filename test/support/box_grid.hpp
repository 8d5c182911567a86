// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "planning/flight_time.hpp"
#include "voxnav/containers/state_grid.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::test {

/// Sets the state of all voxels between two corners, both included.
inline void fill(containers::StateGrid* grid, const geometry::Index3& low, const geometry::Index3& high,
                 containers::VoxelState state) {
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) grid->set({x, y, z}, state);
    }
  }
}

/// Returns a grid with a free box of voxels in unknown space.
inline std::shared_ptr<containers::StateGrid> box_grid(const geometry::Index3& low, const geometry::Index3& high,
                                                       double resolution_m = 1.0) {
  auto grid = std::make_shared<containers::StateGrid>(resolution_m);
  fill(grid.get(), low, high, containers::VoxelState::kFree);
  return grid;
}

}  // namespace voxnav::test
