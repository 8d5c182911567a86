// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "planning/search.hpp"

namespace voxnav::planning {

/// The distances that a shortcut must keep.
struct ShortcutRules {
  double clearance_m = 0.0;    ///< distance from occupied voxels, everywhere
  double known_m = 0.0;        ///< radius of known free space that a shortcut needs within known_range_m of the start
  double known_range_m = 0.0;  ///< range around the start in which the search chose cells amid known space
  geometry::Vec3 start = geometry::Vec3::Zero();
};

/// Keeps a subset of the cells, the first and the last among them, such that each shortcut (the straight segment
/// between two kept cells)
/// - touches only cells that may be entered,
/// - keeps the rules (exactly, see check_corridor()), and
/// - costs no more than the part of the path that it replaces.
/// The farthest such cell is found by doubling and bisection: O(n log n) lines of sight. If time runs out, the rest of
/// the path stays as it is.
std::vector<geometry::Index3> simplify(SearchSpace* space, const OccupancyView& view,
                                       const std::vector<geometry::Index3>& cells, const ShortcutRules& rules,
                                       const SearchBudget& budget);

/// Returns the cost of the straight line between two cell centres [voxel edges]; negative if it touches a cell that may
/// not be entered.
double line_cost(SearchSpace* space, const geometry::Index3& from, const geometry::Index3& to);

}  // namespace voxnav::planning
