// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <optional>
#include <tuple>

#include "graph/graph_steps.hpp"

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

/// Gauss-Newton on the whole graph. Each trial renews the models of the pairs that move, and is kept only if the true
/// cost falls. Renewing models takes most of the time, so that a trial that is known to fail without it is not made.
class Descent {
 public:
  Descent(GraphState* state, int max_evaluations, OptimizeReport* report)
      : state_(state), max_evaluations_(max_evaluations), report_(report) {}

  /// Begins at the input and makes the first step towards the guess. @return costs of the input
  std::vector<KindReport> start(const Estimate& input, const Estimate& guess) {
    std::vector<KindReport> before = exact_costs(input);
    keep(input, total(before));
    step_towards(guess);
    return before;
  }

  std::vector<KindReport> exact_costs(const Estimate& x) {
    linearise_pairs(state_, x.poses, report_);
    return costs_of(*state_, x);
  }

  void run() {
    for (int i = 0; i < state_->config.max_iterations; ++i) {
      ++report_->iterations;
      Estimate target = best_;
      const SolveSummary solved = solve_factors(*state_, 0.0, &target);
      if (!solved.is_usable) return;
      const double move_m = largest_move_m(best_, target);
      report_->is_converged = solved.is_converged && move_m < state_->config.convergence_m;
      if (report_->is_converged) {
        try_out(target);
        return;
      }
      if (was_refused(target, move_m) || !step_towards(target)) {
        // No step towards the minimum of the model lowers the true cost, so the estimate is kept.
        report_->is_converged = move_m < 10.0 * state_->config.convergence_m;
        return;
      }
    }
  }

  const Estimate& best() const { return best_; }

 private:
  /// Stores an estimate as the best so far, with the models that were made there.
  void keep(const Estimate& best, double cost) {
    best_ = best;
    best_cost_ = cost;
    refused_.reset();
    best_models_.clear();
    for (const auto& [ids, pair] : state_->pairs) best_models_.emplace_back(pair.model, pair.factor);
  }
  void restore_models() {
    auto kept = best_models_.begin();
    for (auto& [ids, pair] : state_->pairs) std::tie(pair.model, pair.factor) = *kept++;
  }

  double model_cost(const Estimate& x) const { return total(costs_of(*state_, x)); }

  /// Returns true if the models already show that a step does not lower the cost. Near the estimate at which they were
  /// made, they are as reliable as evaluations of the pairs.
  bool is_hopeless(const Estimate& trial) const {
    constexpr double kModelsHold_m = 0.1;
    return largest_move_m(best_, trial) < kModelsHold_m && model_cost(trial) >= best_cost_;
  }
  /// Returns true if a target is nearly the same as one that was tried in vain.
  bool was_refused(const Estimate& target, double move_m) const {
    return refused_ && largest_move_m(*refused_, target) < 0.2 * move_m;
  }

  /// Makes a trial the best estimate if its true cost is lower; the models are afterwards those of the best. A trial
  /// that has begun is finished, as no decision may rest on half of the pairs, so that the budget may be exceeded by
  /// one evaluation per pair.
  /// @return its cost; nothing if it is hopeless or the budget is used up
  std::optional<double> try_out(const Estimate& trial) {
    if (is_hopeless(trial) || report_->num_pair_evaluations >= max_evaluations_) return std::nullopt;
    const double cost = total(exact_costs(trial));
    if (cost < best_cost_) {
      keep(trial, cost);
    } else {
      restore_models();
    }
    return cost;
  }

  /// Tries the whole step to a target and, if that does not lower the cost, the part of it at the minimum of the
  /// parabola through both costs and the slope at the best estimate. @return whether the cost fell
  bool step_towards(const Estimate& target) {
    constexpr double kLeastGain = 1e-4;  // relative gain of the cost below which no further trial is made
    const double from = best_cost_;
    const double slope = 4.0 * model_cost(between(best_, target, 0.5)) - model_cost(target) - 3.0 * from;
    const std::optional<double> cost = try_out(target);
    if (best_cost_ < from) return true;
    refused_ = target;
    const double curvature = cost ? *cost - from - slope : 0.0;
    if (!(slope < 0.0) || !(curvature > 0.0) || slope * slope < 4.0 * curvature * kLeastGain * from) return false;
    try_out(between(best_, target, std::min(0.5, -0.5 * slope / curvature)));
    return best_cost_ < from;
  }

  GraphState* state_;
  int max_evaluations_;
  OptimizeReport* report_;
  Estimate best_;
  double best_cost_ = 0.0;
  std::optional<Estimate> refused_;  ///< since the last gain
  std::vector<std::pair<PairModel, RelativePoseFactor>> best_models_;
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
    // The submaps must lie near their true places before pairs are formed by their overlap.
    solve_factors(*state, state->config.robust_width, &guess);
    judge_loops(state, is_full, &guess);
    state->estimate = guess;
  }
  update_pairs(state, is_full, &report);
  // The pose graph is solved first with each new pair as registered alone, which may be metres from the present poses.
  solve_factors(*state, state->config.robust_width, &guess);
  judge_loops(state, is_full, &guess);
  update_sways(state, guess.poses);
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
