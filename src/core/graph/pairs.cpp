// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <set>

#include "graph_state.hpp"

namespace voxnav::graph {
namespace {

/// Distance that points of the pair move between two relative poses, yaw taken at the radius of its points.
double motion_m(const Pose4& from, const Pose4& to, double radius_m) {
  const double turn_m = std::abs(geometry::wrap_angle(to[3] - from[3])) * radius_m;
  return (to - from).head<3>().norm() + turn_m;
}

double size_of(const PairOverlap& overlap) { return static_cast<double>(overlap.of_a.size() + overlap.of_b.size()); }

/// Share of the pair's weight that its kernel calls outliers.
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

/// A registration that ends farther away than it may search has run off, whatever it fits.
bool is_within_reach(const GraphState& state, const Pose4& from, const Pose4& to) {
  constexpr double kSlackM = 1.0;
  constexpr double kSlackRad = 0.05;
  return (to - from).head<3>().norm() < state.config.search_range_m + kSlackM &&
         std::abs(geometry::wrap_angle(to[3] - from[3])) < state.config.search_range_rad + kSlackRad;
}

/// Registers one pair by descent on the submaps' own fields. Nearer to the truth more points find observed space, so
/// that points and pose are found in turn.
RegistrationPair descended(const GraphState& state, const Pose4& T_A_B, const RegistrationPair& pair) {
  constexpr int kMaxRounds = 3;
  const double fine_m = state.kernel_m(pair, state.config.fine_kernel_voxels);
  RegistrationPair best = pair;
  choose_points(state, T_A_B, &best);
  if (!best.is_active) return best;
  const SurfaceSample& a = state.nodes.at(pair.a).sample;
  const SurfaceSample& b = state.nodes.at(pair.b).sample;
  set_model(state, evaluate_pair(a, b, best.overlap, T_A_B, fine_m), &best);
  Pose4 at = T_A_B;
  for (int round = 0; round < kMaxRounds; ++round) {
    RegistrationPair next = pair;
    choose_points(state, at, &next);
    if (!next.is_active) break;
    set_model(state, refine_pair(a, b, next.overlap, at, {2.0 * fine_m, fine_m}, state.config.noise_floor), &next);
    const bool is_better = support_of(state, next) > support_of(state, best);
    if (!is_better || !is_within_reach(state, T_A_B, next.model.T_A_B)) break;
    const double moved_m = motion_m(at, next.model.T_A_B, next.model.radius_m);
    at = next.model.T_A_B;
    best = std::move(next);
    if (moved_m < 0.1 * fine_m) break;
  }
  return best;
}

/// The same pair on the coarse fields, which reach metres farther.
struct CoarsePair {
  CoarsePair(const GraphState& s, const RegistrationPair& pair)
      : state(s),
        a(s.nodes.at(pair.a).coarse),
        b(s.nodes.at(pair.b).coarse),
        kernels{s.kernel_m(pair, s.config.coarse_kernel_voxels),
                s.kernel_m(pair, std::max(1.0, 0.5 * s.config.coarse_kernel_voxels))} {}

  PairModel descend(const Pose4& from) const {
    return refine_pair(a, b, overlap_at(from), from, kernels, state.config.noise_floor);
  }
  double misfit_at(const Pose4& at) const {
    return misfit(evaluate_pair(a, b, overlap_at(at), at, kernels.back()), kernels.back());
  }
  PairOverlap overlap_at(const Pose4& at) const { return find_overlap(a, b, at, state.config.coarse_points); }

  const GraphState& state;
  const SurfaceSample& a;
  const SurfaceSample& b;
  std::vector<double> kernels;
};

/// Where the coarse fields put the pair: by descent, or by search where an alignment stands out that fits better.
Pose4 approach(const CoarsePair& coarse, const Pose4& T_A_B, double voxel_m, OptimizeReport* report) {
  const SubmapGraphConfig& config = coarse.state.config;
  const PairModel descended = coarse.descend(T_A_B);
  if (config.search_range_m <= 0.0 || report->num_searches >= config.max_searches) return descended.T_A_B;
  ++report->num_searches;
  const PairSearch search{config.search_range_m, config.search_range_rad, 2.0 * voxel_m, config.search_points,
                          config.search_min_advantage};
  const std::optional<Pose4> found = search_pair(coarse.a, coarse.b, T_A_B, search);
  if (!found) return descended.T_A_B;
  const PairModel searched = coarse.descend(*found);
  return searched.cost_m2 < config.search_min_advantage * descended.cost_m2 ? searched.T_A_B : descended.T_A_B;
}

/// How far a registration has moved in directions that its surfaces leave free: bare ground slid over bare ground
/// explains more of it, and fits as well anywhere.
double unseen_move_m(const RegistrationPair& pair, const Pose4& from) {
  Pose4 move = pair.model.T_A_B - from;
  move[3] = geometry::wrap_angle(move[3]);
  const Matrix4& whitening = pair.factor.whitening;
  const Pose4 seen = whitening.completeOrthogonalDecomposition().solve(whitening * move);
  return motion_m(seen, move, pair.model.radius_m);
}

/// Registers one pair from where the graph has it; the way over the coarse fields has to explain clearly more.
void register_pair(const GraphState& state, const Pose4& T_A_B, RegistrationPair* pair, OptimizeReport* report) {
  RegistrationPair here = descended(state, T_A_B, *pair);
  const CoarsePair coarse(state, *pair);
  const Pose4 start = here.is_active ? here.model.T_A_B : T_A_B;
  if (coarse.misfit_at(start) > state.config.search_outlier_ratio) {
    RegistrationPair there = descended(state, approach(coarse, start, state.voxel_m(*pair), report), *pair);
    const bool explains_more = state.config.search_min_advantage * support_of(state, there) > support_of(state, here);
    if (explains_more && unseen_move_m(there, start) < 0.5 * state.voxel_m(*pair) &&
        is_within_reach(state, T_A_B, there.model.T_A_B))
      here = std::move(there);
  }
  *pair = std::move(here);
}

/// Its points were chosen for another place than where the pair is now. Where registration itself has put it is no such
/// place: a loop that closes brings most pairs there.
bool is_stale(const GraphState& state, const RegistrationPair& pair, const Pose4& T_A_B) {
  const double radius_m = pair.model.radius_m, refresh_m = state.config.overlap_refresh_m;
  if (motion_m(pair.considered_at, T_A_B, radius_m) <= refresh_m) return false;
  return !pair.is_active ||
         motion_m(pair.registered_at, seen_relative(state, state.estimate.poses, pair), radius_m) > refresh_m;
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
    if (is_new || is_full || is_stale(*state, found->second, T_A_B)) out.push_back(&found->second);
  }
  return out;
}

}  // namespace

double GraphState::voxel_m(const RegistrationPair& pair) const {
  return std::max(nodes.at(pair.a).sample.field->resolution_m(), nodes.at(pair.b).sample.field->resolution_m());
}

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

double support_of(const GraphState& state, const RegistrationPair& pair) {
  if (!pair.is_active) return 0.0;
  return pair.overlap.ratio * (1.0 - misfit(pair.model, state.kernel_m(pair, state.config.fine_kernel_voxels)));
}

RegistrationPair register_at(const GraphState& state, int a, int b, const Pose4& T_A_B) {
  RegistrationPair pair;
  pair.a = a;
  pair.b = b;
  return descended(state, T_A_B, pair);
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
    register_pair(*state, T_A_B, pair, report);
    pair->considered_at = T_A_B;
    pair->registered_at = pair->model.T_A_B;
    report->num_new_pairs += pair->is_active;
  }
}

void update_sways(GraphState* state, const std::map<int, Pose4>& poses) {
  constexpr double kTolerance_m = 0.03;
  constexpr double kMost_m = 1.0;  // more is no drift but a jump
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
