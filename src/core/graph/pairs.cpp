// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>

#include "graph_state.hpp"

namespace voxnav::graph {
namespace {

/// Distance that points of the pair move between two relative poses, yaw taken at the radius of its points.
double motion_m(const Pose4& from, const Pose4& to, double radius_m) {
  const double turn_m = std::abs(geometry::wrap_angle(to[3] - from[3])) * radius_m;
  return (to - from).head<3>().norm() + turn_m;
}

double size_of(const PairOverlap& overlap) { return static_cast<double>(overlap.of_a.size() + overlap.of_b.size()); }

std::vector<double> kernels_of(const GraphState& state, const RegistrationPair& pair) {
  const double coarse = state.config.coarse_kernel_voxels;
  const double fine = state.config.fine_kernel_voxels;
  return {state.kernel_m(pair, coarse), state.kernel_m(pair, std::sqrt(coarse * fine)), state.kernel_m(pair, fine)};
}

/// Share of the pair's weight that its best kernel calls outliers.
double misfit(const PairModel& model, double kernel_m) { return model.cost_m2 / (kernel_m * kernel_m); }

void choose_points(const GraphState& state, const Pose4& T_A_B, RegistrationPair* pair) {
  const SubmapGraphConfig& config = state.config;
  pair->overlap =
      find_overlap(state.nodes.at(pair->a).sample, state.nodes.at(pair->b).sample, T_A_B, config.points_per_pair);
  const double size = size_of(pair->overlap);
  pair->is_active = pair->overlap.ratio >= config.min_overlap_ratio && size >= config.min_points_per_pair;
  const double fullness = std::min(1.0, size / (2.0 * config.points_per_pair));
  pair->information = config.registration_effective_points * fullness / std::pow(config.registration_sigma_m, 2);
}

void set_model(const GraphState& state, const PairModel& model, RegistrationPair* pair) {
  const double fine_m = state.kernel_m(*pair, state.config.fine_kernel_voxels);
  pair->model = model;
  pair->factor = to_factor(model, pair->information, state.config.noise_floor, fine_m);
}

/// Registers one pair by itself, from where the graph has it; searches when descent ends in a misfit.
void register_pair(const GraphState& state, const Pose4& T_A_B, RegistrationPair* pair, OptimizeReport* report) {
  const SubmapGraphConfig& config = state.config;
  const SurfaceSample& a = state.nodes.at(pair->a).sample;
  const SurfaceSample& b = state.nodes.at(pair->b).sample;
  const std::vector<double> kernels = kernels_of(state, *pair);
  PairModel model = refine_pair(a, b, pair->overlap, T_A_B, kernels, config.noise_floor);
  const bool may_search = config.search_range_m > 0.0 && report->num_searches < config.max_searches;
  if (may_search && misfit(model, kernels.back()) > config.search_outlier_ratio) {
    ++report->num_searches;
    const PairSearch search{config.search_range_m, config.search_range_rad, 2.0 * state.voxel_m(*pair),
                            config.search_points, config.search_min_advantage};
    const std::optional<Pose4> found = search_pair(a, b, T_A_B, search);
    if (found) {
      RegistrationPair moved = *pair;
      choose_points(state, *found, &moved);
      const PairModel better = refine_pair(a, b, moved.overlap, *found, kernels, config.noise_floor);
      const double advantage = config.search_min_advantage;
      if (moved.is_active && misfit(better, kernels.back()) < advantage * misfit(model, kernels.back())) {
        *pair = std::move(moved);
        model = better;
      }
    }
  }
  set_model(state, model, pair);
}

bool is_stale(const RegistrationPair& pair, const Pose4& T_A_B, double refresh_m) {
  return motion_m(pair.considered_at, T_A_B, pair.model.radius_m) > refresh_m;
}

/// Pairs to (re)consider: candidates of the index, at most so many per submap, unknown or moved since.
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
    if (is_new || is_full || is_stale(found->second, T_A_B, config.overlap_refresh_m)) out.push_back(&found->second);
  }
  return out;
}

}  // namespace

double GraphState::voxel_m(const RegistrationPair& pair) const {
  return std::max(nodes.at(pair.a).sample.field->resolution_m(), nodes.at(pair.b).sample.field->resolution_m());
}

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
    pair->considered_at = T_A_B;
    choose_points(*state, T_A_B, pair);
    if (!pair->is_active) continue;
    register_pair(*state, T_A_B, pair, report);
    ++report->num_new_pairs;
  }
}

bool linearise_pairs(GraphState* state, const std::map<int, Pose4>& poses, int max_evaluations,
                     OptimizeReport* report) {
  constexpr double kToleranceVoxels = 0.02;
  for (auto& [ids, pair] : state->pairs) {
    if (!pair.is_active) continue;
    const Pose4 T_A_B = relative_of(poses, pair.a, pair.b);
    if (motion_m(pair.model.T_A_B, T_A_B, pair.model.radius_m) < state->kernel_m(pair, kToleranceVoxels)) continue;
    if (report->num_pair_evaluations >= max_evaluations) return false;
    ++report->num_pair_evaluations;
    const double fine_m = state->kernel_m(pair, state->config.fine_kernel_voxels);
    set_model(
        *state,
        evaluate_pair(state->nodes.at(pair.a).sample, state->nodes.at(pair.b).sample, pair.overlap, T_A_B, fine_m),
        &pair);
  }
  return true;
}

}  // namespace voxnav::graph
