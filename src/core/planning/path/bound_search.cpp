// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/bound_search.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {

using Number = RunGraph::Number;

namespace {
constexpr std::uint64_t kUnit = BoundSearch::kStraight * 2 * kUnitCost;
}

BoundSearch::End BoundSearch::run(Number start, WorkBudget* budget) {
  relax(start, 0);
  while (!open_.empty()) {
    if (budget->expansions_left == 0 || memory_bytes() + graph_.memory_bytes() > budget->max_bytes) return End::kLimit;
    const auto top = open_.pop();
    if (reached(top.place).is_closed) continue;
    reached(top.place).is_closed = true;
    --budget->expansions_left;
    ++expansions_;
    last_f_ = top.f;
    if (top.place == goal_) return End::kGoal;
    expand(top.place, top.cost);
  }
  return graph_.has_refused() ? End::kLimit : End::kExhausted;
}

std::uint64_t BoundSearch::heuristic(Number number) const {
  const RunGraph::Node& a = graph_.node(number);
  const RunGraph::Node& b = graph_.node(goal_);
  const auto dx = static_cast<std::uint64_t>(std::abs(a.x - b.x)), dy = static_cast<std::uint64_t>(std::abs(a.y - b.y));
  return (kDiagonal * std::min(dx, dy) + kStraight * (std::max(dx, dy) - std::min(dx, dy))) * 2 * kUnitCost;
}

void BoundSearch::expand(Number from, std::uint64_t cost) {
  const std::uint64_t here = graph_.node(from).run.cost;
  graph_.for_each_beside(from, [&](Number to, const RunGraph::Step& step, int, int) {
    const std::uint64_t length = step.dx != 0 && step.dy != 0 ? kDiagonal : kStraight;
    relax(to, cost + length * (here + graph_.node(to).run.cost));
  });
  const RunGraph::Node node = graph_.node(from);
  const RunGraph::Column column = graph_.column(node.x, node.y);
  if (from > column.first && graph_.node(from - 1).run.high + 1 == node.run.low) {
    relax(from - 1, cost + kVertical * (here + graph_.node(from - 1).run.cost));
  }
  if (from + 1 < column.end && graph_.node(from + 1).run.low == node.run.high + 1) {
    relax(from + 1, cost + kVertical * (here + graph_.node(from + 1).run.cost));
  }
}

void BoundSearch::relax(Number to, std::uint64_t cost) {
  Reached& there = reached(to);
  if (cost >= there.cost || there.is_closed) return;
  there.cost = cost;
  const std::uint64_t rest = heuristic(to);
  // With a weight of 1 the sum stays exact: a double could not hold the costs of the longest paths.
  const std::uint64_t weighted =
      weight_ == 1.0 ? rest : static_cast<std::uint64_t>(weight_ * static_cast<double>(rest));
  open_.push(cost + weighted, cost, to);
}

double BoundSearch::goal_cost() const { return static_cast<double>(reached_[goal_].cost) / static_cast<double>(kUnit); }

double BoundSearch::bound(Number number) const {
  if (number < reached_.size() && reached_[number].is_closed) {
    return static_cast<double>(reached_[number].cost) / static_cast<double>(kUnit);
  }
  // What was not expanded is no nearer than this, since the heuristic is consistent.
  const std::uint64_t rest = heuristic(number);
  return rest < last_f_ ? static_cast<double>(last_f_ - rest) / static_cast<double>(kUnit) : 0.0;
}

Number BoundSearch::nearest_to(const geometry::Vec3& point) const {
  Number best = RunGraph::kNone;
  double best_squared = std::numeric_limits<double>::infinity();
  for (Number n = 0; n < reached_.size(); ++n) {
    if (!reached_[n].is_closed) continue;
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
