// SPDX-License-Identifier: BSD-3-Clause
#include "planning/way_out.hpp"

#include <algorithm>
#include <cmath>
#include <queue>
#include <unordered_map>

#include "planning/moves.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;

/// Bound on the work: a search that touches more cells than this is given up.
constexpr std::size_t kMaxCells = 20000;

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

std::vector<Index3> find_way_out(const Index3& start, double radius_cells, const WayOutRules& rules) {
  using Item = std::pair<double, Index3>;
  std::priority_queue<Item, std::vector<Item>, std::greater<Item>> open;
  Ways ways = {{start, {0.0, start}}};
  open.push({0.0, start});
  while (!open.empty() && ways.size() < kMaxCells && !rules.is_late()) {
    const auto [length, voxel] = open.top();
    open.pop();
    if (length > ways[voxel].length) continue;
    if (rules.is_out(voxel)) return way_to(ways, start, voxel);
    std::uint32_t crossable = 0;
    for (int move = 0; move < kNumMoves; ++move) {
      if (move != kNoMove && rules.may_cross(voxel + moves()[move].step)) crossable |= 1u << move;
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
