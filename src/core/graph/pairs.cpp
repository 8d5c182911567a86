// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

/// Returns true if the points of a pair were chosen at another relative pose than it has now. The pose to which its own
/// registration moved it does not count as another one, because closing a loop brings most pairs there.
bool is_stale(const GraphState& state, const RegistrationPair& pair, const Pose4& T_A_B) {
  const double radius_m = pair.model.radius_m, refresh_m = state.config.overlap_refresh_m;
  if (motion_m(pair.considered_at, T_A_B, radius_m) <= refresh_m) return false;
  return !pair.is_active ||
         motion_m(pair.registered_at, seen_relative(state, state.estimate.poses, pair), radius_m) > refresh_m;
}

/// Returns the pairs that have to be registered: those that overlap and are new or stale, in bounded numbers.
std::vector<RegistrationPair*> pairs_to_form(GraphState* state, bool is_full) {
  std::vector<RegistrationPair*> out;
  const SubmapGraphConfig& config = state->config;
  const std::size_t limit = static_cast<std::size_t>(config.max_new_pairs) * (is_full ? 10 : 1);
  int last_b = -1;
  int taken = 0;
  for (const CandidatePair& candidate : overlapping_submaps(*state, state->estimate.poses)) {
    taken = candidate.b == last_b ? taken + 1 : 1;
    last_b = candidate.b;
    if (taken > config.max_pairs_per_submap || out.size() >= limit) continue;
    const auto key = std::make_pair(candidate.a, candidate.b);
    auto found = state->pairs.find(key);
    const bool is_new = found == state->pairs.end();
    if (is_new) {
      if (state->pairs.size() >= static_cast<std::size_t>(config.max_pairs)) continue;
      found = state->pairs.emplace(key, RegistrationPair()).first;
      found->second.a = candidate.a;
      found->second.b = candidate.b;
    }
    const Pose4 T_A_B = relative_of(state->estimate.poses, candidate.a, candidate.b);
    if (is_new || is_full || is_stale(*state, found->second, T_A_B)) out.push_back(&found->second);
  }
  return out;
}

}  // namespace

double pair_cost(const RegistrationPair& pair, const Pose4& T_A_B) {
  Pose4 d = T_A_B - pair.model.T_A_B;
  d[3] = geometry::wrap_angle(d[3]);
  const double cost_m2 = pair.model.cost_m2 + 2.0 * pair.model.gradient.dot(d) + d.dot(pair.model.hessian * d);
  return pair.information * std::max(0.0, cost_m2);
}

void update_pairs(GraphState* state, bool is_full, OptimizeReport* report) {
  if (!state->uses(ConstraintKind::kRegistration)) return;
  for (RegistrationPair* pair : pairs_to_form(state, is_full)) {
    const Pose4 T_A_B = relative_of(state->estimate.poses, pair->a, pair->b);
    register_pair(*state, T_A_B, pair, report);
    pair->considered_at = T_A_B;
    pair->registered_at = pair->model.T_A_B;
    report->num_new_pairs += pair->is_active;
  }
}

void linearise_pairs(GraphState* state, const std::map<int, Pose4>& poses, OptimizeReport* report) {
  constexpr double kToleranceVoxels = 0.02;
  for (auto& [ids, pair] : state->pairs) {
    if (!pair.is_active) continue;
    const Pose4 T_A_B = seen_relative(*state, poses, pair);
    const bool has_moved =
        motion_m(pair.model.T_A_B, T_A_B, pair.model.radius_m) >= state->kernel_m(pair, kToleranceVoxels);
    if (!has_moved && !pair.is_bent_anew) continue;
    pair.is_bent_anew = false;
    ++report->num_pair_evaluations;
    const double fine_m = state->kernel_m(pair, state->config.fine_kernel_voxels);
    set_model(
        *state,
        evaluate_pair(state->nodes.at(pair.a).sample, state->nodes.at(pair.b).sample, pair.overlap, T_A_B, fine_m),
        &pair);
  }
}

}  // namespace voxnav::graph
