// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::planning {

/// Cells as a way out of a blocked start sees them.
struct WayOutRules {
  std::function<bool(const geometry::Index3&)> may_cross;  ///< a way out may lead through the cell
  std::function<bool(const geometry::Index3&)> is_out;     ///< the cell may be entered by a path
  std::function<bool()> is_late = [] { return false; };    ///< ends the search
};

/// Finds the shortest way out of cells that may be crossed but not entered, to the first cell that a path may enter,
/// with 26 neighbours and without corner cutting.
/// @return cells from `start` on; empty if there is no way out within the radius
std::vector<geometry::Index3> find_way_out(const geometry::Index3& start, double radius_cells,
                                           const WayOutRules& rules);

}  // namespace voxnav::planning
