// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

constexpr std::size_t kMaxPending = 500;

/// Returns true if ordinary registration of the pair would search there too, so that no loop closure is needed.
bool is_within_search(const GraphState& state, const Pose4& from, const Pose4& to) {
  return (to - from).head<3>().norm() < state.config.search_range_m &&
         std::abs(geometry::wrap_angle(to[3] - from[3])) < state.config.search_range_rad;
}

/// Returns the support of the pair at its present pose in the graph.
double present_support(const GraphState& state, int a, int b) {
  const auto found = state.pairs.find({a, b});
  return found == state.pairs.end() ? 0.0 : support_of(state, found->second);
}

/// Registers b at the pose at which its place was recognised in a; nothing if the surfaces do not fit there.
std::optional<RecognisedLoop> verified(const GraphState& state, int a, int b) {
  const auto match = match_places(state.nodes.at(a).place, state.nodes.at(b).place);
  if (!match) return std::nullopt;
  if (is_within_search(state, relative_of(state.estimate.poses, a, b), match->T_A_B)) return std::nullopt;
  const RegistrationPair pair = register_at(state, a, b, match->T_A_B);
  const double support = support_of(state, pair);
  const bool explains_more = state.config.search_min_advantage * support > present_support(state, a, b);
  if (support < state.config.place_min_support || !explains_more) return std::nullopt;
  if (!is_within_search(state, match->T_A_B, pair.model.T_A_B)) return std::nullopt;
  return RecognisedLoop{a, b, pair.factor, false};
}

/// Returns the number of steps between two submaps in the order of ids.
int steps_between(const GraphState& state, int a, int b) {
  const auto low = state.nodes.find(std::min(a, b));
  const auto high = state.nodes.find(std::max(a, b));
  return static_cast<int>(std::distance(low, high));
}

/// Returns true if two loops confirm each other: they join the same two stretches of the flight, and together with the
/// graph along these few submaps they close a circle.
bool confirm_each_other(const GraphState& state, const RecognisedLoop& l, const RecognisedLoop& r) {
  constexpr int kMaxSteps = 4;
  constexpr double kClosed_m = 1.0;
  constexpr double kClosed_rad = 0.08;
  if (l.a == r.a && l.b == r.b) return false;
  if (steps_between(state, l.a, r.a) > kMaxSteps || steps_between(state, l.b, r.b) > kMaxSteps) return false;
  const auto& poses = state.estimate.poses;
  const Pose4 around = compose(compose(relative_of(poses, l.a, r.a), r.factor.T_a_b), relative_of(poses, r.b, l.b));
  const Pose4 gap = around - l.factor.T_a_b;
  return gap.head<3>().norm() < kClosed_m && std::abs(geometry::wrap_angle(gap[3])) < kClosed_rad;
}

void confirm(GraphState* state, RecognisedLoop* loop, OptimizeReport* report) {
  if (loop->is_confirmed) return;
  loop->is_confirmed = true;
  RelativeConstraint constraint{loop->a, loop->b, loop->factor, ConstraintKind::kLoop, LoopState::kUntested, {}, true};
  state->relatives.push_back(std::move(constraint));
  ++report->num_recognised;
}

void add_loop(GraphState* state, RecognisedLoop loop, OptimizeReport* report) {
  for (RecognisedLoop& other : state->recognised) {
    if (!confirm_each_other(*state, loop, other)) continue;
    confirm(state, &loop, report);
    confirm(state, &other, report);
  }
  if (state->recognised.size() >= kMaxPending) state->recognised.erase(state->recognised.begin());
  state->recognised.push_back(std::move(loop));
}

}  // namespace

int recognise_places(GraphState* state, OptimizeReport* report) {
  if (!state->uses(ConstraintKind::kRegistration) || !state->uses(ConstraintKind::kLoop)) return 0;
  std::sort(state->unrecognised.begin(), state->unrecognised.end());
  for (const int id : state->unrecognised) {
    const std::vector<int> similar =
        state->places.similar(id, state->nodes.at(id).place, state->config.place_candidates);
    for (const int other : similar) {
      if (auto loop = verified(*state, std::min(id, other), std::max(id, other))) add_loop(state, *loop, report);
    }
  }
  state->unrecognised.clear();
  return report->num_recognised;
}

}  // namespace voxnav::graph
