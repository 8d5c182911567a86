// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "voxnav/planning/search.hpp"

namespace voxnav::planning {

/// Keeps a subset of the cells (first and last among them) such that each straight piece between kept neighbours
/// - touches enterable cells only,
/// - stays `clearance_m` away from the occupied voxels of the view (exact, see check_corridor), and
/// - costs no more than the pieces it replaces.
/// Searches by doubling, then bisection: O(n log n) lines of sight. When time runs out the rest stays as it is.
std::vector<geometry::Index3> simplify(SearchSpace* space, const OccupancyView& view,
                                       const std::vector<geometry::Index3>& cells, double clearance_m,
                                       const SearchBudget& budget);

/// Cost of the straight line between two cell centres in voxel edges; negative when it touches a cell that may not
/// be entered.
double line_cost(SearchSpace* space, const geometry::Index3& from, const geometry::Index3& to);

}  // namespace voxnav::planning
