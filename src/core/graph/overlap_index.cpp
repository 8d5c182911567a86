// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <unordered_map>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

constexpr std::size_t kMaxSubmapsPerCell = 128;

using CellMembers = std::unordered_map<geometry::Index3, std::vector<int>, geometry::Index3Hash>;

/// Ids of the submaps in each cell of the map, ascending because nodes are visited in that order.
CellMembers cells_in_map(const GraphState& state, const std::map<int, Pose4>& poses) {
  CellMembers cells;
  for (const auto& [id, node] : state.nodes) {
    const geometry::Pose T_W_S = to_pose(poses.at(id));
    for (const geometry::Index3& block : node.blocks_S) {
      const geometry::Vec3 center_W = T_W_S * geometry::center_of(block, state.config.pair_block_m);
      std::vector<int>& members = cells[geometry::index_of(center_W, state.config.pair_block_m)];
      if (!members.empty() && members.back() == id) continue;
      members.push_back(id);
      if (members.size() > kMaxSubmapsPerCell) members.erase(members.begin());
    }
  }
  return cells;
}

}  // namespace

std::vector<CandidatePair> overlapping_submaps(const GraphState& state, const std::map<int, Pose4>& poses) {
  std::map<std::pair<int, int>, int> shared;
  for (const auto& [cell, members] : cells_in_map(state, poses)) {
    for (std::size_t j = 1; j < members.size(); ++j) {
      for (std::size_t i = 0; i < j; ++i) ++shared[{members[i], members[j]}];
    }
  }
  std::vector<CandidatePair> out;
  out.reserve(shared.size());
  for (const auto& [ids, count] : shared) out.push_back({ids.first, ids.second, count});
  std::sort(out.begin(), out.end(), [](const CandidatePair& l, const CandidatePair& r) {
    if (l.b != r.b) return l.b < r.b;
    return l.shared != r.shared ? l.shared > r.shared : l.a > r.a;
  });
  return out;
}

}  // namespace voxnav::graph
