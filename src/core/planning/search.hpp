// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <chrono>
#include <vector>

#include "planning/search_space.hpp"
#include "voxnav/planning/plan_result.hpp"
#include "voxnav/planning/stop_flag.hpp"

namespace voxnav::planning {

/// Limits shared by all loops of one planning call. The flag, or the clock where there is none, bounds the effort;
/// nothing else depends on it.
struct SearchBudget {
  const StopFlag* stop = nullptr;
  std::chrono::steady_clock::time_point deadline;
  std::uint64_t max_expansions = 0;
  std::size_t max_open = 0;
  bool is_late() const { return stop != nullptr ? stop->is_raised() : std::chrono::steady_clock::now() >= deadline; }
};

enum class SearchEnd { kGoal, kExhausted, kTimeout, kLimit };

struct SearchOutcome {
  SearchEnd end = SearchEnd::kExhausted;
  std::vector<geometry::Index3> cells;  ///< to the goal, or to the expanded cell nearest to it
  double cost_cells = 0.0;              ///< in voxel edges
  std::uint64_t expansions = 0;
  std::size_t open_bytes = 0;
};

/// The A* loop. @param start, goal enterable or not; only enterable neighbours are entered.
SearchOutcome search(SearchSpace* space, const geometry::Index3& start, const geometry::Index3& goal,
                     double heuristic_weight, const SearchBudget& budget);

/// Nearest enterable cell around `center` by distance, ties by index; at most `radius_m` away.
bool nearest_enterable(SearchSpace* space, const geometry::Index3& center, double radius_cells,
                       const SearchBudget& budget, geometry::Index3* out);

/// Shortest way out of cells that are not occupied but may not be entered, to the first enterable cell; never
/// through occupied cells, and through unknown ones only when `may_cross_unknown`. Empty when there is none
/// within the radius. The result starts at `start`.
std::vector<geometry::Index3> escape(SearchSpace* space, CellCosts* costs, const geometry::Index3& start,
                                     double radius_cells, bool may_cross_unknown, const SearchBudget& budget);

}  // namespace voxnav::planning
