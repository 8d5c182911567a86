// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/lattice_search.hpp"

#include <algorithm>
#include <cmath>

#include "planning/moves.hpp"

namespace voxnav::planning {

using geometry::Index3;
using geometry::Vec3;

namespace {

const std::array<double, 4> kStepLength = {0.0, 1.0, std::sqrt(2.0), std::sqrt(3.0)};

/// The length of the shortest path with 26 neighbours in empty space.
double octile(const Index3& a, const Index3& b) {
  std::array<int, 3> d = {std::abs(a.x - b.x), std::abs(a.y - b.y), std::abs(a.z - b.z)};
  std::sort(d.begin(), d.end());
  return kStepLength[1] * (d[2] - d[1]) + kStepLength[2] * (d[1] - d[0]) + kStepLength[3] * d[0];
}

}  // namespace

std::vector<Vec3> LatticeSearch::run(const Index3& start, const Index3& goal, WorkBudget* budget) {
  const Number first = graph_.find(goal), last = graph_.find(start);
  if (first == RunGraph::kNone || last == RunGraph::kNone) return {};
  start_ = start;
  const Place begin{first, goal.z};
  cell(begin).cost = 0.0;
  push(begin);
  while (!open_.empty()) {
    if (budget->expansions_left == 0 || memory_bytes() + graph_.memory_bytes() > budget->max_bytes) return {};
    const Place top = open_.pop().place;
    if (cell(top).is_closed) continue;
    cell(top).is_closed = true;
    --budget->expansions_left;
    ++expansions_;
    if (top.number == last && top.z == start.z) return trace(start, goal);
    expand(top);
  }
  return {};
}

LatticeSearch::Cell& LatticeSearch::cell(const Place& place) {
  if (place.number >= first_cell_.size()) first_cell_.resize(graph_.size(), RunGraph::kNone);
  const CellRun& run = graph_.node(place.number).run;
  std::uint32_t& first = first_cell_[place.number];
  if (first == RunGraph::kNone) {
    first = static_cast<std::uint32_t>(cells_.size());
    cells_.resize(cells_.size() + static_cast<std::size_t>(run.high - run.low + 1));
  }
  return cells_[first + static_cast<std::uint32_t>(place.z - run.low)];
}

double LatticeSearch::heuristic(const Place& place) const {
  const RunGraph::Node& node = graph_.node(place.number);
  return std::max(bounds_.bound(place.number), octile({node.x, node.y, place.z}, start_));
}

void LatticeSearch::push(const Place& place) {
  const double cost = cell(place).cost;
  open_.push(cost + weight_ * heuristic(place), cost, place);
}

void LatticeSearch::expand(const Place& from) {
  const RunGraph::Node node = graph_.node(from.number);
  std::array<Number, kNumMoves> runs;
  std::uint32_t enterable = 0;
  for (int side = 0; side < 9; ++side) {
    const RunGraph::Column column = graph_.column(node.x + side % 3 - 1, node.y + side / 3 - 1);
    for (Number n = column.first; n < column.end; ++n) {
      const CellRun& run = graph_.node(n).run;
      for (int z = std::max(run.low, from.z - 1); z <= std::min(run.high, from.z + 1); ++z) {
        const int move = side + 9 * (z - from.z + 1);
        runs[move] = n;
        enterable |= 1u << move;
      }
    }
  }
  const double cost = cell(from).cost;
  for (int move = 0; move < kNumMoves; ++move) {
    const Move& step = moves()[move];
    if (move == kNoMove || (enterable & step.touched) != step.touched) continue;
    const Place to{runs[move], from.z + step.step.z};
    const double mean = (graph_.node(to.number).run.cost + node.run.cost) / (2.0 * kUnitCost);
    const double next = cost + kStepLength[step.num_axes] * mean;
    Cell& there = cell(to);
    if (next >= there.cost || there.is_closed) continue;
    there.cost = next;
    there.move = static_cast<std::uint8_t>(kNumMoves - 1 - move);
    push(to);
  }
}

std::vector<Vec3> LatticeSearch::trace(Index3 at, const Index3& goal) {
  std::vector<Vec3> out = {geometry::center_of(at, 1.0)};
  while (at != goal) {
    at = at + moves()[cell({graph_.find(at), at.z}).move].step;
    out.push_back(geometry::center_of(at, 1.0));
  }
  return out;
}

}  // namespace voxnav::planning
