// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "planning/search.hpp"

namespace voxnav::planning {

/// What a straight piece must keep.
struct ShortcutRules {
  double clearance_m = 0.0;    ///< from occupied voxels, everywhere
  double known_m = 0.0;        ///< of known free space around it, as far as `known_range_m` from `start`
  double known_range_m = 0.0;  ///< a piece that lacks it replaces nothing: the cells were chosen with care there
  geometry::Vec3 start = geometry::Vec3::Zero();
};

/// Keeps a subset of the cells (first and last among them) such that each straight piece between kept neighbours
/// - touches enterable cells only,
/// - keeps the rules (exact, see check_corridor), and
/// - costs no more than the pieces it replaces.
/// Searches by doubling, then bisection: O(n log n) lines of sight. When time runs out the rest stays as it is.
std::vector<geometry::Index3> simplify(SearchSpace* space, const OccupancyView& view,
                                       const std::vector<geometry::Index3>& cells, const ShortcutRules& rules,
                                       const SearchBudget& budget);

/// Cost of the straight line between two cell centres in voxel edges; negative when it touches a cell that may not
/// be entered.
double line_cost(SearchSpace* space, const geometry::Index3& from, const geometry::Index3& to);

}  // namespace voxnav::planning
