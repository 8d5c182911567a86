// SPDX-License-Identifier: BSD-3-Clause
// Poses of submaps at the times when they saw something, and the drift within submaps.
#include <algorithm>
#include <cmath>
#include <set>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {

SeenFrom seen_from(const GraphState& state, int id, double phase) {
  const bool is_before = phase < 0.5;
  const std::map<int, Neighbour>& neighbours = is_before ? state.before : state.after;
  const auto found = neighbours.find(id);
  if (found == neighbours.end()) return {id, id, {}};
  return {id, found->second.id, {std::min(0.5, std::abs(phase - 0.5)), is_before, found->second.step}};
}

Pose4 seen_relative(const GraphState& state, const std::map<int, Pose4>& poses, const RegistrationPair& pair) {
  return relative(seen_from(state, pair.a, pair.overlap.phase_a).pose(poses),
                  seen_from(state, pair.b, pair.overlap.phase_b).pose(poses));
}

void update_sways(GraphState* state, const std::map<int, Pose4>& poses) {
  constexpr double kTolerance_m = 0.03;
  constexpr double kMost_m = 1.0;  // a larger shift is a jump of the odometry, not drift
  std::set<int> changed;
  for (auto& [id, node] : state->nodes) {
    if (!node.sample.field) continue;
    const auto shift_at = [&, id = id](double phase) -> geometry::Vec3 {
      const Pose4 shift = relative(poses.at(id), seen_from(*state, id, phase).pose(poses));
      return shift.head<3>().norm() < kMost_m ? geometry::Vec3(shift.head<3>())
                                              : geometry::Vec3(geometry::Vec3::Zero());
    };
    const Sway sway{shift_at(0.0), shift_at(1.0)};
    const double change_m =
        std::max((sway.begin_S - node.sample.sway.begin_S).norm(), (sway.end_S - node.sample.sway.end_S).norm());
    if (change_m < kTolerance_m) continue;
    node.sample.sway = sway;
    changed.insert(id);
  }
  for (auto& [ids, pair] : state->pairs) pair.is_bent_anew |= changed.count(pair.a) > 0 || changed.count(pair.b) > 0;
}

}  // namespace voxnav::graph
