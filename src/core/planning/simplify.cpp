// SPDX-License-Identifier: BSD-3-Clause
#include "planning/simplify.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "planning/segment_box.hpp"
#include "voxnav/planning/corridor.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;

constexpr double kTolerance = 1e-9;

CellCost cost_at(SearchSpace* space, const Index3& voxel) {
  CellRef cell;
  return space->locate(voxel, &cell) ? space->cost(cell) : CellCost{0};
}

/// Walks from cell to cell along the line between two centres.
/// Source: Amanatides & Woo, A Fast Voxel Traversal Algorithm for Ray Tracing, Eurographics 1987.
struct LineWalk {
  Index3 voxel;
  std::array<int, 3> step;
  std::array<double, 3> next;   ///< line parameter of the next cell boundary on each axis
  std::array<double, 3> delta;  ///< difference of the line parameter between two boundaries on each axis

  LineWalk(const Index3& from, const Index3& to) : voxel(from) {
    const std::array<int, 3> d = {to.x - from.x, to.y - from.y, to.z - from.z};
    for (int k = 0; k < 3; ++k) {
      step[k] = (d[k] > 0) - (d[k] < 0);
      delta[k] = d[k] != 0 ? 1.0 / std::abs(d[k]) : 2.0;
      next[k] = d[k] != 0 ? 0.5 * delta[k] : 2.0;
    }
  }
  Index3 moved(int axes) const {
    return voxel + Index3{(axes & 1) ? step[0] : 0, (axes & 2) ? step[1] : 0, (axes & 4) ? step[2] : 0};
  }
  /// Returns the axes, as bits, on which the line crosses a boundary next: several at an edge or a corner.
  int crossing(double* t) const {
    *t = std::min({next[0], next[1], next[2]});
    int axes = 0;
    for (int k = 0; k < 3; ++k) axes |= (next[k] < *t + kTolerance) << k;
    return axes;
  }
  void cross(int axes) {
    voxel = moved(axes);
    for (int k = 0; k < 3; ++k) {
      if ((axes >> k) & 1) next[k] += delta[k];
    }
  }
};

class Simplifier {
 public:
  Simplifier(SearchSpace* space, const OccupancyView& view, const std::vector<Index3>& cells,
             const ShortcutRules& rules)
      : space_(space), view_(view), cells_(cells), rules_(rules), cost_to_(cells.size(), 0.0) {
    for (std::size_t i = 1; i < cells.size(); ++i) {
      cost_to_[i] = cost_to_[i - 1] + std::max(0.0, line_cost(space, cells[i - 1], cells[i]));
    }
  }

  /// Returns the farthest cell to which a straight line from cell `from` may replace the path.
  std::size_t farthest_from(std::size_t from) const {
    std::size_t good = from + 1, stride = 1;
    while (good + stride < cells_.size() && is_replaceable(from, good + stride)) {
      good += stride;
      stride *= 2;
    }
    std::size_t bad = std::min(cells_.size(), good + stride);
    while (bad - good > 1) {
      const std::size_t middle = (good + bad) / 2;
      (is_replaceable(from, middle) ? good : bad) = middle;
    }
    return good;
  }

 private:
  bool is_replaceable(std::size_t from, std::size_t to) const {
    const double cost = line_cost(space_, cells_[from], cells_[to]);
    if (cost < 0.0 || cost > cost_to_[to] - cost_to_[from] + kTolerance) return false;
    const double v = view_.resolution_m();
    const Segment line{geometry::center_of(cells_[from], v), geometry::center_of(cells_[to], v)};
    const bool is_clear =
        rules_.clearance_m <= 0.0 ||
        check_corridor(view_, {line.a, line.b}, rules_.clearance_m, CorridorRule::kNotOccupied).is_safe;
    return is_clear && is_known_near_start(line);
  }

  bool is_known_near_start(const Segment& line) const {
    if (rules_.known_m <= 0.0 || (line.a - rules_.start).norm() >= rules_.known_range_m) return true;
    // Only the part up to where the segment leaves the range is checked: a path that comes back into the range is flown
    // there much later, when a newer plan has replaced this one.
    const geometry::Aabb point{rules_.start, rules_.start};
    const bool ends_within = (line.b - rules_.start).norm() <= rules_.known_range_m;
    const Segment back{line.b, line.a};
    const geometry::Vec3 end =
        ends_within ? line.b : back.at(first_parameter_within(back, point, rules_.known_range_m));
    return check_corridor(view_, {line.a, end}, rules_.known_m).is_safe;
  }

  SearchSpace* space_;
  const OccupancyView& view_;
  const std::vector<Index3>& cells_;
  const ShortcutRules& rules_;
  std::vector<double> cost_to_;
};

}  // namespace

double line_cost(SearchSpace* space, const Index3& from, const Index3& to) {
  const double length = std::sqrt(std::pow(to.x - from.x, 2) + std::pow(to.y - from.y, 2) + std::pow(to.z - from.z, 2));
  // A start that may not be entered counts as a cell of unit cost, as in the search.
  CellCost here = std::max(cost_at(space, from), kUnitCost);
  LineWalk walk(from, to);
  double cost = 0.0, before = 0.0, t = 0.0;
  for (int axes = walk.crossing(&t); t < 1.0; axes = walk.crossing(&t)) {
    cost += (t - before) * length * here / kUnitCost;
    before = t;
    for (int subset = (axes - 1) & axes; subset > 0; subset = (subset - 1) & axes) {
      if (cost_at(space, walk.moved(subset)) == 0) return -1.0;
    }
    walk.cross(axes);
    here = cost_at(space, walk.voxel);
    if (here == 0) return -1.0;
  }
  return cost + (1.0 - before) * length * here / kUnitCost;
}

std::vector<Index3> simplify(SearchSpace* space, const OccupancyView& view, const std::vector<Index3>& cells,
                             const ShortcutRules& rules, const SearchBudget& budget) {
  if (cells.size() < 3) return cells;
  const Simplifier simplifier(space, view, cells, rules);
  std::vector<Index3> out = {cells.front()};
  for (std::size_t at = 0; at + 1 < cells.size();) {
    at = budget.is_late() ? at + 1 : simplifier.farthest_from(at);
    out.push_back(cells[at]);
  }
  return out;
}

}  // namespace voxnav::planning
