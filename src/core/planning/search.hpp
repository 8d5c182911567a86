// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <vector>

#include "planning/search_space.hpp"
#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/plan_result.hpp"

namespace voxnav::planning {

/// Limits shared by all loops of one planning call. Only whether it is late depends on the time.
struct SearchBudget {
  std::chrono::steady_clock::time_point deadline;
  std::uint64_t max_expansions = 0;
  std::size_t max_open = 0;
  bool is_late() const { return std::chrono::steady_clock::now() >= deadline; }
};

enum class SearchEnd { kGoal, kExhausted, kTimeout, kLimit };

struct SearchOutcome {
  SearchEnd end = SearchEnd::kExhausted;
  std::vector<geometry::Index3> cells;  ///< path to the goal, or to the expanded cell nearest to it
  double cost_cells = 0.0;              ///< cost of the path [voxel edges at unit cost]
  std::uint64_t expansions = 0;
  std::size_t open_bytes = 0;
};

/// The A* loop. Only cells that may be entered are expanded into; the start is exempt, and a goal that may not be
/// entered is never reached.
SearchOutcome search(SearchSpace* space, const geometry::Index3& start, const geometry::Index3& goal,
                     double heuristic_weight, const SearchBudget& budget);

/// Finds the cell nearest to `center` that may be entered; ties go to the lower index.
/// @return false if there is none within `radius_cells`
bool nearest_enterable(SearchSpace* space, const geometry::Index3& center, double radius_cells,
                       const SearchBudget& budget, geometry::Index3* out);

/// Finds the shortest way out of cells that are not occupied but may not be entered, to the first cell that may. It
/// never leads through occupied cells, and through unknown ones only if `may_cross_unknown` is set.
/// @return cells from `start` on; empty if there is no way out within the radius
std::vector<geometry::Index3> escape(SearchSpace* space, CellCosts* costs, const geometry::Index3& start,
                                     double radius_cells, bool may_cross_unknown, const SearchBudget& budget);

}  // namespace voxnav::planning
