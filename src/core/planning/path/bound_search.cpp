// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/bound_search.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {

using Number = RunGraph::Number;

BoundSearch::End BoundSearch::run(Number start, WorkBudget* budget) {
  relax(start, 0);
  while (!open_.empty()) {
    if (budget->expansions_left == 0 || memory_bytes() + graph_.memory_bytes() > budget->max_bytes) return End::kLimit;
    const auto top = open_.pop();
    if (reached_[top.place].is_closed()) continue;
    reached_[top.place].close();
    --budget->expansions_left;
    ++expansions_;
    last_f_ = std::max(last_f_, top.f);
    if (top.place == goal_) return End::kGoal;
    expand(top.place, top.cost);
  }
  return graph_.has_refused() ? End::kLimit : End::kExhausted;
}

std::uint64_t BoundSearch::heuristic(const RunGraph::Node& node) const {
  const auto dx = static_cast<std::uint64_t>(std::abs(node.x - goal_node_.x));
  const auto dy = static_cast<std::uint64_t>(std::abs(node.y - goal_node_.y));
  return (kDiagonal * std::min(dx, dy) + kStraight * (std::max(dx, dy) - std::min(dx, dy))) * 2 * kUnitCost;
}

/// As RunGraph::for_each_beside(), but most runs are passed over by their costs before anything else is looked at.
void BoundSearch::expand(Number from, std::uint64_t cost) {
  const RunGraph::Node node = graph_.node(from);
  const auto beside = graph_.columns_beside(node);
  if (reached_.size() < graph_.size()) reached_.resize(graph_.size());
  for (int i = 0; i < 8; ++i) {
    const bool is_diagonal = i >= 4;
    const RunGraph::Step step = RunGraph::kSteps[i];
    const RunGraph::Column &x_side = beside[step.dx > 0 ? 0 : 1], &y_side = beside[step.dy > 0 ? 2 : 3];
    if (is_diagonal && (x_side.is_empty() || y_side.is_empty())) continue;
    for (Number to = beside[i].first; to < beside[i].end; ++to) {
      const CellRun& run = graph_.node(to).run;
      const std::uint64_t next = cost + (is_diagonal ? kDiagonal : kStraight) * (node.run.cost + run.cost);
      if (!reached_[to].is_dearer(next)) continue;
      const int low = std::max(node.run.low, run.low), high = std::min(node.run.high, run.high);
      if (low > high) continue;
      if (is_diagonal && !(graph_.opens_within(x_side, low, high) && graph_.opens_within(y_side, low, high))) continue;
      reach(to, next);
    }
  }
  const RunGraph::Column column = graph_.column(node.x, node.y);
  if (from > column.first && graph_.node(from - 1).run.high + 1 == node.run.low) {
    relax(from - 1, cost + kVertical * (node.run.cost + graph_.node(from - 1).run.cost));
  }
  if (from + 1 < column.end && graph_.node(from + 1).run.low == node.run.high + 1) {
    relax(from + 1, cost + kVertical * (node.run.cost + graph_.node(from + 1).run.cost));
  }
}

void BoundSearch::relax(Number to, std::uint64_t cost) {
  if (reached(to).is_dearer(cost)) reach(to, cost);
}

void BoundSearch::reach(Number to, std::uint64_t cost) {
  reached_[to].set_cost(cost);
  const std::uint64_t rest = heuristic(graph_.node(to));
  // With a weight of 1 the sum stays exact: a double could not hold the costs of the longest paths.
  const std::uint64_t weighted =
      weight_ == 1.0 ? rest : static_cast<std::uint64_t>(weight_ * static_cast<double>(rest));
  open_.push(cost + weighted, cost, to);
}

double BoundSearch::goal_cost() const {
  return static_cast<double>(reached_[goal_].cost()) / static_cast<double>(kUnit);
}

double BoundSearch::bound(Number number) const {
  if (number < reached_.size() && reached_[number].is_closed()) {
    return static_cast<double>(reached_[number].cost()) / static_cast<double>(kUnit);
  }
  // What was not expanded is no nearer than this, since the heuristic is consistent.
  const std::uint64_t rest = heuristic(graph_.node(number));
  return rest < last_f_ ? static_cast<double>(last_f_ - rest) / static_cast<double>(kUnit) : 0.0;
}

double BoundSearch::leading_cost(Number number) const {
  if (number < reached_.size() && reached_[number].is_reached()) {
    return static_cast<double>(reached_[number].cost()) / static_cast<double>(kUnit);
  }
  const double rest = weight_ * static_cast<double>(heuristic(graph_.node(number)));
  return std::max(0.0, static_cast<double>(last_f_) - rest) / static_cast<double>(kUnit);
}

Number BoundSearch::nearest_to(const geometry::Vec3& point) const {
  Number best = RunGraph::kNone;
  double best_squared = std::numeric_limits<double>::infinity();
  for (Number n = 0; n < reached_.size(); ++n) {
    if (!reached_[n].is_closed()) continue;
    const RunGraph::Node& node = graph_.node(n);
    const double dz = point.z() - std::min(std::max(point.z(), node.run.low + 0.5), node.run.high + 0.5);
    const double squared = std::pow(point.x() - node.x - 0.5, 2) + std::pow(point.y() - node.y - 0.5, 2) + dz * dz;
    if (squared >= best_squared) continue;
    best = n;
    best_squared = squared;
  }
  return best;
}

}  // namespace voxnav::planning
