// SPDX-License-Identifier: BSD-3-Clause
// Registration of one pair of submaps.
#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

double size_of(const PairOverlap& overlap) { return static_cast<double>(overlap.of_a.size() + overlap.of_b.size()); }

/// Returns the cost of a model as a share of the cost if every point were an outlier.
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

/// Returns true if a registration ended within the range of the search. One that ended beyond it has diverged, however
/// well it fits there.
bool is_within_reach(const GraphState& state, const Pose4& from, const Pose4& to) {
  constexpr double kSlackM = 1.0;
  constexpr double kSlackRad = 0.05;
  return (to - from).head<3>().norm() < state.config.search_range_m + kSlackM &&
         std::abs(geometry::wrap_angle(to[3] - from[3])) < state.config.search_range_rad + kSlackRad;
}

/// Registers one pair by descent on the submaps' own fields. Points and pose are chosen in turn, since nearer to the
/// truth more points of one submap lie in the observed space of the other.
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

/// A pair with the coarse fields of its submaps, which reach metres farther than the submaps' own.
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

/// Returns the relative pose that the coarse fields suggest: that of descent, or that of a grid search if the search
/// finds one alignment that stands out and fits clearly better.
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

/// Returns how far a registration moved the pair in directions that its surfaces do not determine. Bare ground that
/// slides over bare ground overlaps more and more and fits equally well everywhere, so such a move is no evidence.
double unseen_move_m(const RegistrationPair& pair, const Pose4& from) {
  Pose4 move = pair.model.T_A_B - from;
  move[3] = geometry::wrap_angle(move[3]);
  const Matrix4& whitening = pair.factor.whitening;
  const Pose4 seen = whitening.completeOrthogonalDecomposition().solve(whitening * move);
  return motion_m(seen, move, pair.model.radius_m);
}

}  // namespace

double GraphState::voxel_m(const RegistrationPair& pair) const {
  return std::max(nodes.at(pair.a).sample.field->resolution_m(), nodes.at(pair.b).sample.field->resolution_m());
}

double motion_m(const Pose4& from, const Pose4& to, double radius_m) {
  const double turn_m = std::abs(geometry::wrap_angle(to[3] - from[3])) * radius_m;
  return (to - from).head<3>().norm() + turn_m;
}

void set_model(const GraphState& state, const PairModel& model, RegistrationPair* pair) {
  const double fine_m = state.kernel_m(*pair, state.config.fine_kernel_voxels);
  pair->model = model;
  pair->factor = to_factor(model, pair->information, state.config.noise_floor, fine_m);
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

}  // namespace voxnav::graph
