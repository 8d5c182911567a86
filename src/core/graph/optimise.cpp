// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <limits>

#include "graph_state.hpp"

namespace voxnav::graph {
namespace {

constexpr double kYawRadiusM = 20.0;  // where a turn of a submap is felt, for the test of convergence

double total(const std::vector<KindReport>& kinds) {
  double sum = 0.0;
  for (const KindReport& kind : kinds) sum += kind.cost_after;
  return sum;
}

double largest_move_m(const Estimate& from, const Estimate& to) {
  double largest = 0.0;
  for (const auto& [id, pose] : from.poses) {
    const Pose4 d = to.poses.at(id) - pose;
    largest = std::max({largest, d.head<3>().norm(), std::abs(geometry::wrap_angle(d[3])) * kYawRadiusM});
  }
  return largest;
}

Pose4 between(const Pose4& from, const Pose4& to, double ratio) {
  Pose4 out = from + ratio * (to - from);
  out[3] = geometry::wrap_angle(from[3] + ratio * geometry::wrap_angle(to[3] - from[3]));
  return out;
}

Estimate between(const Estimate& from, const Estimate& to, double ratio) {
  Estimate out = from;
  for (auto& [id, pose] : out.poses) pose = between(from.poses.at(id), to.poses.at(id), ratio);
  out.datum = between(from.datum, to.datum, ratio);
  return out;
}

/// Gauss-Newton on the whole graph with step halving: each trial renews the models of the pairs that move and counts
/// only if the true cost falls.
class Descent {
 public:
  Descent(GraphState* state, int max_evaluations, OptimizeReport* report)
      : state_(state), max_evaluations_(max_evaluations), report_(report) {}

  /// Takes the better of the two by true cost. @return costs of the input
  std::vector<KindReport> start(const Estimate& input, const Estimate& guess) {
    const std::vector<KindReport> before = exact_costs(input);
    best_ = input;
    best_cost_ = total(before);
    accept_if_better(guess);
    return before;
  }

  /// Not limited by the budget, as no decision may rest on half of the pairs: at most one evaluation per pair.
  std::vector<KindReport> exact_costs(const Estimate& x) {
    linearise_pairs(state_, x.poses, std::numeric_limits<int>::max(), report_);
    return costs_of(*state_, x);
  }

  void run() {
    for (int i = 0; i < state_->config.max_iterations; ++i) {
      ++report_->iterations;
      Estimate target = best_;
      // Renew the models at the best estimate: a refused trial left them elsewhere.
      if (!linearise_pairs(state_, best_.poses, max_evaluations_, report_)) return;
      const SolveSummary solved = solve_factors(*state_, 0.0, &target);
      if (!solved.is_usable) return;
      const double move_m = largest_move_m(best_, target);
      report_->is_converged = solved.is_converged && move_m < state_->config.convergence_m;
      if (!step_towards(target) || report_->is_converged) return;
    }
  }

  const Estimate& best() const { return best_; }

 private:
  bool accept_if_better(const Estimate& trial) {
    if (!linearise_pairs(state_, trial.poses, max_evaluations_, report_)) return false;
    const double cost = total(costs_of(*state_, trial));
    if (!(cost < best_cost_)) return false;
    best_ = trial;
    best_cost_ = cost;
    return true;
  }

  bool step_towards(const Estimate& target) {
    const Estimate origin = best_;
    for (const double ratio : {1.0, 0.5, 0.25}) {
      if (accept_if_better(ratio == 1.0 ? target : between(origin, target, ratio))) return true;
    }
    // No step along the model's minimum lowers the true cost: this is as good as it gets.
    report_->is_converged = largest_move_m(origin, target) < 10.0 * state_->config.convergence_m;
    return false;
  }

  GraphState* state_;
  int max_evaluations_;
  OptimizeReport* report_;
  Estimate best_;
  double best_cost_ = 0.0;
};

void fill_report(const GraphState& state, const std::vector<KindReport>& before, const std::vector<KindReport>& after,
                 OptimizeReport* report) {
  for (int k = 0; k < kNumConstraintKinds; ++k) {
    report->kinds[k] = after[static_cast<std::size_t>(k)];
    report->kinds[k].cost_before = before[static_cast<std::size_t>(k)].cost_after;
  }
  report->cost_before = total(before);
  report->cost_after = total(after);
  report->num_submaps = static_cast<int>(state.nodes.size());
  for (const auto& [ids, pair] : state.pairs) report->num_pairs += pair.is_active;
  for (const RelativeConstraint& c : state.relatives) {
    const bool is_rejected = c.kind == ConstraintKind::kLoop && c.state == LoopState::kRejected;
    if (is_rejected) report->rejected_loops.push_back({c.a, c.b, c.reason});
  }
}

}  // namespace

OptimizeReport optimise(GraphState* state, bool is_full) {
  OptimizeReport report;
  if (state->nodes.empty()) {
    report.is_converged = report.is_input_kept = true;
    return report;
  }
  initialise_datum(state);
  const Estimate input = state->estimate;
  const int max_evaluations = state->config.max_pair_evaluations * (is_full ? 10 : 1);
  Estimate guess = input;
  if (recognise_places(state, &report) > 0) {
    // The submaps have to lie near their places before pairs are formed from where they lie.
    solve_factors(*state, state->config.robust_width, &guess);
    judge_loops(state, is_full, &guess);
    state->estimate = guess;
  }
  update_pairs(state, is_full, &report);
  // First the pose graph with each new pair as registered by itself, which may be metres away from here.
  solve_factors(*state, state->config.robust_width, &guess);
  judge_loops(state, is_full, &guess);
  Descent descent(state, max_evaluations, &report);
  const std::vector<KindReport> before = descent.start(input, guess);
  descent.run();
  const std::vector<KindReport> after = descent.exact_costs(descent.best());
  const bool is_better = total(after) <= total(before);
  report.is_input_kept = !is_better || largest_move_m(input, descent.best()) == 0.0;
  fill_report(*state, before, is_better ? after : before, &report);
  state->estimate = is_better ? descent.best() : input;
  return report;
}

}  // namespace voxnav::graph
