// SPDX-License-Identifier: BSD-3-Clause
#include "planning/search.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {
namespace {

/// Costs are integers so that equal paths compare equal: one voxel edge at unit cost is 2^24 * 2 * kUnitCost.
constexpr std::uint64_t kStraight = std::uint64_t{1} << 24;
const std::array<std::uint64_t, 4> kStepLength = {0, kStraight,
                                                  static_cast<std::uint64_t>(std::llround(std::sqrt(2.0) * kStraight)),
                                                  static_cast<std::uint64_t>(std::llround(std::sqrt(3.0) * kStraight))};
constexpr std::uint64_t kHeuristicUnit = std::uint64_t{2} * kUnitCost;

struct Entry {
  std::uint64_t f;
  std::uint64_t g;
  CellRef cell;
};

/// Heap order: the smallest f is on top, among equals the largest g, then the lowest cell number, so that the order
/// depends on nothing else.
struct ComesLater {
  bool operator()(const Entry& a, const Entry& b) const {
    if (a.f != b.f) return a.f > b.f;
    if (a.g != b.g) return a.g < b.g;
    if (a.cell.block != b.cell.block) return a.cell.block > b.cell.block;
    return a.cell.offset > b.cell.offset;
  }
};

/// Octile distance: the length of the shortest 26-connected path in empty space.
std::uint64_t octile(const geometry::Index3& a, const geometry::Index3& b) {
  std::array<std::uint64_t, 3> d = {static_cast<std::uint64_t>(std::abs(a.x - b.x)),
                                    static_cast<std::uint64_t>(std::abs(a.y - b.y)),
                                    static_cast<std::uint64_t>(std::abs(a.z - b.z))};
  std::sort(d.begin(), d.end());
  return kStepLength[1] * (d[2] - d[1]) + kStepLength[2] * (d[1] - d[0]) + kStepLength[3] * d[0];
}

class AStarSearch {
 public:
  AStarSearch(SearchSpace* space, const geometry::Index3& goal, double weight, const SearchBudget& budget)
      : space_(*space),
        goal_(goal),
        weight_(static_cast<std::uint64_t>(std::llround(weight * kHeuristicUnit))),
        budget_(budget) {
    open_.reserve(std::min<std::size_t>(budget.max_open, 1 << 16));
  }

  SearchOutcome run(const geometry::Index3& start) {
    CellRef cell;
    if (!space_.locate(start, &cell)) return finish(SearchEnd::kLimit);
    space_.block(cell).g[cell.offset] = 0;
    best_ = cell;
    best_h_ = kUnreached;
    push(cell, 0);
    return finish(loop());
  }

 private:
  SearchEnd loop() {
    for (std::uint64_t pops = 0; !open_.empty(); ++pops) {
      if (outcome_.expansions >= budget_.max_expansions || is_full_) return SearchEnd::kLimit;
      if (pops % 256 == 0 && budget_.is_late()) return SearchEnd::kTimeout;
      std::pop_heap(open_.begin(), open_.end(), ComesLater());
      const Entry top = open_.back();
      open_.pop_back();
      SearchSpace::Block& block = space_.block(top.cell);
      if (top.g != block.g[top.cell.offset] || is_closed(block, top.cell)) continue;
      block.arrived_by[top.cell.offset] |= SearchSpace::kClosed;
      ++outcome_.expansions;
      if (note_best(top.cell, top.g)) return SearchEnd::kGoal;
      expand(top.cell, top.g);
    }
    return space_.has_refused() ? SearchEnd::kLimit : SearchEnd::kExhausted;
  }

  static bool is_closed(const SearchSpace::Block& block, CellRef cell) {
    return (block.arrived_by[cell.offset] & SearchSpace::kClosed) != 0;
  }

  /// Expands a cell; returns true if it is the goal.
  bool note_best(CellRef cell, std::uint64_t g) {
    const std::uint64_t h = octile(space_.voxel(cell), goal_);
    if (h < best_h_ || (h == best_h_ && g < best_g_)) {
      best_ = cell;
      best_h_ = h;
      best_g_ = g;
    }
    return h == 0;
  }

  void expand(CellRef from, std::uint64_t g) {
    std::array<CellRef, kNumMoves> cells;
    std::uint32_t enterable = 0;
    for (int move = 0; move < kNumMoves; ++move) {
      if (move != kNoMove && space_.step(from, move, &cells[move]) && space_.cost(cells[move]) != 0) {
        enterable |= 1u << move;
      }
    }
    // If the start itself may not be entered, the step that leaves it is charged as from a cell of unit cost.
    const std::uint64_t here = std::max<CellCost>(space_.cost(from), kUnitCost);
    for (int move = 0; move < kNumMoves; ++move) {
      const Move& step = moves()[move];
      if (move == kNoMove || (enterable & step.touched) != step.touched) continue;
      const std::uint64_t next_g = g + kStepLength[step.num_axes] * (here + space_.cost(cells[move]));
      SearchSpace::Block& block = space_.block(cells[move]);
      // A closed cell stays closed: with weight 1 it has its least cost already, because the octile distance is
      // consistent, and with weight w at most w times that. Without the rule a weighted search may expand cells again
      // and again. Source: Likhachev, Gordon & Thrun, ARA*, NIPS 2003, section 2.
      if (next_g >= block.g[cells[move].offset] || is_closed(block, cells[move])) continue;
      block.g[cells[move].offset] = next_g;
      block.arrived_by[cells[move].offset] = static_cast<std::uint8_t>(move);
      push(cells[move], next_g);
    }
  }

  void push(CellRef cell, std::uint64_t g) {
    if (open_.size() >= budget_.max_open) {
      is_full_ = true;
      return;
    }
    open_.push_back({g + octile(space_.voxel(cell), goal_) * weight_, g, cell});
    std::push_heap(open_.begin(), open_.end(), ComesLater());
  }

  SearchOutcome finish(SearchEnd end) {
    outcome_.end = end;
    outcome_.open_bytes = open_.capacity() * sizeof(Entry);
    if (best_h_ != kUnreached) trace_back();
    return outcome_;
  }

  /// Follows the moves back from the best cell to the start, the only cell to which no move led. Each cell was closed
  /// after its predecessor and keeps its move from then on, so the walk cannot run in circles.
  void trace_back() {
    CellRef cell = best_;
    for (;;) {
      const geometry::Index3 voxel = space_.voxel(cell);
      outcome_.cells.push_back(voxel);
      const int move = space_.block(cell).arrived_by[cell.offset] & ~SearchSpace::kClosed;
      if (move == kNoMove) break;
      const CellCost there = space_.cost(cell);
      space_.locate(voxel - moves()[move].step, &cell);
      outcome_.cost_cells += std::sqrt(static_cast<double>(moves()[move].num_axes)) *
                             (there + std::max<CellCost>(space_.cost(cell), kUnitCost)) / kHeuristicUnit;
    }
    std::reverse(outcome_.cells.begin(), outcome_.cells.end());
  }

  SearchSpace& space_;
  geometry::Index3 goal_;
  std::uint64_t weight_;
  SearchBudget budget_;
  std::vector<Entry> open_;
  SearchOutcome outcome_;
  CellRef best_;
  std::uint64_t best_h_ = kUnreached;
  std::uint64_t best_g_ = 0;
  bool is_full_ = false;
};

}  // namespace

SearchOutcome search(SearchSpace* space, const geometry::Index3& start, const geometry::Index3& goal,
                     double heuristic_weight, const SearchBudget& budget) {
  return AStarSearch(space, goal, heuristic_weight, budget).run(start);
}

}  // namespace voxnav::planning
