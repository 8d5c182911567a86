// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/any_angle_search.hpp"

#include <algorithm>
#include <cmath>

#include "planning/path/sight.hpp"

namespace voxnav::planning {

using geometry::Vec3;

namespace {

constexpr double kTolerance = 1e-9;
/// Steps over columns are up to 8.2 % longer than straight lines, and about 4 % in the mean over all directions: bounds
/// are scaled by that, so that they lead to short paths rather than to paths that fit the lattice.
constexpr double kLatticeExcess = 1.04;

/// Difference of the costs of two runs beyond which lines between them are looked at before they are believed.
constexpr int kJump = kUnitCost;

double clamp(double value, double low, double high) { return std::min(std::max(value, low), high); }

}  // namespace

std::vector<Vec3> AnyAngleSearch::run(Number start, Number goal, const Vec3& goal_point, WorkBudget* budget) {
  start_run_ = start;
  place(goal).position = goal_point;
  place(goal).cost = 0.0;
  place(goal).is_seen = true;
  push(goal);
  while (!open_.empty()) {
    if (budget->expansions_left == 0 || memory_bytes() + graph_.memory_bytes() > budget->max_bytes) return {};
    const auto top = open_.pop();
    if (place(top.place).is_closed || top.cost != place(top.place).cost) continue;
    if (!check_sight(top.place)) continue;
    place(top.place).is_closed = true;
    --budget->expansions_left;
    ++expansions_;
    if (top.place == start) return trace();
    expand(top.place);
  }
  return {};
}

double AnyAngleSearch::heuristic(Number number, const Vec3& position) const {
  const double flat = bounds_.bound(number) / kLatticeExcess;
  const double height = position.z() - start_.z();
  return std::sqrt(flat * flat + height * height);
}

void AnyAngleSearch::push(Number number) {
  const Place& p = place(number);
  open_.push(p.cost + heuristic(number, p.position), p.cost, number);
}

/// Checks the line of sight to the parent; returns false if that made the run dearer, which is in the open list then.
bool AnyAngleSearch::check_sight(Number number) {
  if (place(number).is_seen) return true;
  place(number).is_seen = true;
  const Place before = place(number);
  const auto seen = sight_cost(&graph_, place(before.parent).position, before.position, SightRule::kEnterable);
  double best = seen ? place(before.parent).cost + *seen : std::numeric_limits<double>::infinity();
  Number parent = before.parent;
  if (best > before.cost + kTolerance) {
    const auto consider = [&](Number from) {
      if (!place(from).is_closed) return;
      const auto step = step_cost(from, number);
      if (!step || place(from).cost + *step >= best) return;
      best = place(from).cost + *step;
      parent = from;
    };
    const auto is_closed = [this](Number from) { return place(from).is_closed; };
    graph_.for_each_beside(number, is_closed, [&](Number from, const RunGraph::Step&, int, int) { consider(from); });
    const RunGraph::Column column = graph_.column(graph_.node(number).x, graph_.node(number).y);
    if (number > column.first) consider(number - 1);
    if (number + 1 < column.end) consider(number + 1);
  }
  Place& p = place(number);
  p.parent = parent;
  p.cost = best;
  if (best <= before.cost + kTolerance) return true;
  if (std::isfinite(best)) push(number);
  return false;
}

bool AnyAngleSearch::opens_at(int x, int y, double height) {
  return graph_.find({x, y, static_cast<int>(std::floor(height))}) != RunGraph::kNone;
}

/// The height at which a step leads from one run to one beside it; nothing if it may not be made.
std::optional<double> AnyAngleSearch::step_height(Number from, Number to) {
  const RunGraph::Node a = graph_.node(from), b = graph_.node(to);
  const int low = std::max(a.run.low, b.run.low), high = std::min(a.run.high, b.run.high);
  if (low > high) return std::nullopt;
  const double height = clamp(place(to).position.z(), low + 0.5, high + 0.5);
  const bool is_diagonal = a.x != b.x && a.y != b.y;
  if (is_diagonal && !(opens_at(a.x, b.y, height) && opens_at(b.x, a.y, height))) return std::nullopt;
  return height;
}

/// Cost of stepping between neighbouring runs: up or down in the first one, level, and up or down in the second one.
std::optional<double> AnyAngleSearch::step_cost(Number from, Number to) {
  const RunGraph::Node a = graph_.node(from), b = graph_.node(to);
  const Vec3 from_position = place(from).position, to_position = place(to).position;
  if (a.x == b.x && a.y == b.y) {
    const bool is_next = a.run.high + 1 == b.run.low || b.run.high + 1 == a.run.low;
    if (!is_next) return std::nullopt;
    return (from_position - to_position).norm() * mean_cost(from, to);
  }
  const auto height = step_height(from, to);
  if (!height) return std::nullopt;
  return std::abs(from_position.z() - *height) * a.run.cost / kUnitCost +
         (from_position - to_position).head<2>().norm() * mean_cost(from, to) +
         std::abs(to_position.z() - *height) * b.run.cost / kUnitCost;
}

void AnyAngleSearch::expand(Number from) {
  const auto is_wanted = [this](Number to) { return !place(to).is_closed; };
  graph_.for_each_beside(from, is_wanted,
                         [&](Number to, const RunGraph::Step&, int low, int high) { relax(from, to, low, high); });
  const RunGraph::Node node = graph_.node(from);
  const RunGraph::Column column = graph_.column(node.x, node.y);
  if (from > column.first && graph_.node(from - 1).run.high + 1 == node.run.low) {
    relax(from, from - 1, node.run.low - 1, node.run.low - 1);
  }
  if (from + 1 < column.end && graph_.node(from + 1).run.low == node.run.high + 1) {
    relax(from, from + 1, node.run.high + 1, node.run.high + 1);
  }
}

void AnyAngleSearch::relax(Number from, Number to, int low, int high) {
  if (place(to).is_closed) return;
  const Place here = place(from);
  const Number parent = here.parent == RunGraph::kNone ? from : here.parent;
  const Vec3 turn = place(parent).position;
  Vec3 position = start_;
  if (to != start_run_) {
    const RunGraph::Node& node = graph_.node(to);
    position = Vec3(node.x + 0.5, node.y + 0.5, 0.0);
    const double done = (position - turn).head<2>().norm(), left = bounds_.bound(to) / kLatticeExcess;
    const double height = turn.z() + (start_.z() - turn.z()) * done / std::max(done + left, kTolerance);
    position.z() = clamp(height, low + 0.5, high + 0.5);
  }
  const double mean = mean_cost(from, to);
  double through = here.cost + std::max(0.0, (position - turn).norm() - (here.position - turn).norm()) * mean;
  // Where costs jump, a guess from both sides is worth nothing.
  const bool is_jump = std::abs(graph_.node(from).run.cost - graph_.node(to).run.cost) > kJump;
  if (is_jump && parent != from) {
    const auto seen = sight_cost(&graph_, turn, position, SightRule::kEnterable);
    through = seen ? place(parent).cost + *seen : std::numeric_limits<double>::infinity();
  }
  const double direct = here.cost + (position - here.position).norm() * mean;
  const bool is_through = through <= direct + kTolerance;
  const double cost = is_through ? through : direct;
  Place& there = place(to);
  if (cost >= there.cost - kTolerance) return;
  there.position = position;
  there.cost = cost;
  there.parent = is_through ? parent : from;
  there.is_seen = false;
  push(to);
}

std::vector<Vec3> AnyAngleSearch::trace() {
  std::vector<Vec3> out;
  for (Number n = start_run_;; n = place(n).parent) {
    out.push_back(place(n).position);
    const Number parent = place(n).parent;
    if (parent == RunGraph::kNone) return out;
    const Vec3 a = place(n).position, b = place(parent).position;
    if (sight_cost(&graph_, a, b, SightRule::kEnterable)) continue;
    const auto height = step_height(parent, n);
    if (!height) continue;
    out.emplace_back(a.x(), a.y(), *height);
    out.emplace_back(b.x(), b.y(), *height);
  }
}

}  // namespace voxnav::planning
