// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "graph/graph_steps.hpp"

namespace voxnav::graph {
namespace {

/// The loss that the solver applies (ceres::CauchyLoss), so that costs reported here are those it minimises.
double cauchy(double squared, double width) { return width * width * std::log1p(squared / (width * width)); }

void add(double cost, KindReport* kind) {
  ++kind->num_constraints;
  kind->cost_after += cost;
}

double position_cost(const PositionConstraint& c, const Estimate& estimate) {
  const Pose4 datum = c.is_in_map_frame ? Pose4::Zero() : estimate.datum;
  return c.factor.evaluate(estimate.poses.at(c.id), datum, nullptr, nullptr).squaredNorm();
}

}  // namespace

std::vector<KindReport> costs_of(const GraphState& state, const Estimate& estimate) {
  std::vector<KindReport> kinds(kNumConstraintKinds);
  const auto& poses = estimate.poses;
  const double width = state.config.robust_width;
  for (const RelativeConstraint& c : state.relatives) {
    if (!state.uses(c)) continue;
    const double cost = c.factor.evaluate(poses.at(c.a), poses.at(c.b), nullptr, nullptr).squaredNorm();
    add(cost, &kinds[static_cast<std::size_t>(c.kind)]);
  }
  for (const auto& [ids, pair] : state.pairs) {
    if (!pair.is_active || !state.uses(ConstraintKind::kRegistration)) continue;
    add(pair_cost(pair, seen_relative(state, poses, pair)),
        &kinds[static_cast<std::size_t>(ConstraintKind::kRegistration)]);
  }
  for (const PositionConstraint& c : state.positions) {
    if (!state.uses(ConstraintKind::kGnss)) break;
    add(cauchy(position_cost(c, estimate), width), &kinds[static_cast<std::size_t>(ConstraintKind::kGnss)]);
  }
  for (const HeightConstraint& c : state.heights) {
    if (!state.uses(ConstraintKind::kHeight)) break;
    const double residual = c.factor.evaluate(poses.at(c.id));
    add(cauchy(residual * residual, width), &kinds[static_cast<std::size_t>(ConstraintKind::kHeight)]);
  }
  return kinds;
}

}  // namespace voxnav::graph
