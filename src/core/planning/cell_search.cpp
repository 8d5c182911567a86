// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <queue>

#include "planning/search.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;

/// Bound on the work of an escape: a search that touches more cells than this is given up.
constexpr std::size_t kMaxEscapeCells = 20000;

std::int64_t distance_sq(const Index3& a, const Index3& b) {
  const std::int64_t x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

bool is_enterable(SearchSpace* space, const Index3& voxel) {
  CellRef cell;
  return space->locate(voxel, &cell) && space->cost(cell) != 0;
}

/// Calls fn for each cell whose largest axis offset from the centre is `ring`.
template <class Fn>
void for_each_in_ring(const Index3& center, int ring, Fn fn) {
  for (int z = -ring; z <= ring; ++z) {
    for (int y = -ring; y <= ring; ++y) {
      const bool is_face = std::abs(z) == ring || std::abs(y) == ring;
      const int step = is_face || ring == 0 ? 1 : 2 * ring;
      for (int x = -ring; x <= ring; x += step) fn(center + Index3{x, y, z});
    }
  }
}

struct Way {
  double length;
  Index3 parent;
};
using Ways = std::unordered_map<Index3, Way, geometry::Index3Hash>;

std::vector<Index3> way_to(const Ways& ways, const Index3& start, Index3 voxel) {
  std::vector<Index3> out = {voxel};
  while (voxel != start) {
    voxel = ways.at(voxel).parent;
    out.push_back(voxel);
  }
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace

bool nearest_enterable(SearchSpace* space, const Index3& center, double radius_cells, const SearchBudget& budget,
                       Index3* out) {
  const double radius_sq = radius_cells * radius_cells;
  double best_sq = std::numeric_limits<double>::infinity();
  for (int ring = 0; ring <= radius_cells && static_cast<double>(ring) * ring <= best_sq; ++ring) {
    if (budget.is_late()) break;
    for_each_in_ring(center, ring, [&](const Index3& voxel) {
      const auto d = static_cast<double>(distance_sq(voxel, center));
      if (d > radius_sq || d > best_sq || (d == best_sq && !(voxel < *out)) || !is_enterable(space, voxel)) return;
      best_sq = d;
      *out = voxel;
    });
  }
  return std::isfinite(best_sq);
}

std::vector<Index3> escape(SearchSpace* space, CellCosts* costs, const Index3& start, double radius_cells,
                           bool may_cross_unknown, const SearchBudget& budget) {
  const auto may_cross = [&](const Index3& voxel) {
    const VoxelState state = costs->state(voxel);
    return costs->is_inside(voxel) && state != VoxelState::kOccupied &&
           (may_cross_unknown || state == VoxelState::kFree);
  };
  using Item = std::pair<double, Index3>;
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> open;
  Ways ways = {{start, {0.0, start}}};
  open.push({0.0, start});
  while (!open.empty() && ways.size() < kMaxEscapeCells && !budget.is_late()) {
    const auto [length, voxel] = open.top();
    open.pop();
    if (length > ways[voxel].length) continue;
    if (is_enterable(space, voxel)) return way_to(ways, start, voxel);
    std::uint32_t crossable = 0;
    for (int move = 0; move < kNumMoves; ++move) {
      if (move != kNoMove && may_cross(voxel + moves()[move].step)) crossable |= 1u << move;
    }
    for (int move = 0; move < kNumMoves; ++move) {
      const Move& step = moves()[move];
      const Index3 next = voxel + step.step;
      const double next_length = length + std::sqrt(static_cast<double>(step.num_axes));
      if (move == kNoMove || (crossable & step.touched) != step.touched || next_length > radius_cells) continue;
      const auto [it, is_new] = ways.try_emplace(next, Way{next_length, voxel});
      if (!is_new && it->second.length <= next_length) continue;
      it->second = {next_length, voxel};
      open.push({next_length, next});
    }
  }
  return {};
}

}  // namespace voxnav::planning
