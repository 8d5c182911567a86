// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/run_search.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav::planning {

using geometry::Vec3;

namespace {

constexpr double kTolerance = 1e-9;

/// Appends a point; the one before it is left out if it lies between two others on a straight line.
void append(const Vec3& point, std::vector<Vec3>* points) {
  if (!points->empty() && (point - points->back()).squaredNorm() < kTolerance) return;
  const std::size_t n = points->size();
  if (n >= 2) {
    const Vec3 before = (*points)[n - 1] - (*points)[n - 2], after = point - (*points)[n - 1];
    if (before.cross(after).squaredNorm() < kTolerance && before.dot(after) > 0.0) points->pop_back();
  }
  points->push_back(point);
}

}  // namespace

std::vector<Vec3> RunSearch::run(const End& start, const End& goal, WorkBudget* budget) {
  start_height_ = start.point.z();
  place(goal.run).height = goal.point.z();
  place(goal.run).cost = 0.0;
  open_.push(0.0, 0.0, goal.run);
  while (!open_.empty()) {
    if (budget->expansions_left == 0 || memory_bytes() + graph_.memory_bytes() > budget->max_bytes) return {};
    const Number top = open_.pop().place;
    if (place(top).is_closed) continue;
    place(top).is_closed = true;
    --budget->expansions_left;
    ++expansions_;
    if (top == start.run) return trace(start, goal);
    expand(top);
  }
  return {};
}

bool RunSearch::opens_at(int x, int y, double height) {
  return graph_.find({x, y, static_cast<int>(std::floor(height))}) != RunGraph::kNone;
}

void RunSearch::expand(Number from) {
  const RunGraph::Node node = graph_.node(from);
  const double here = place(from).height;
  const auto is_wanted = [this](Number to) { return !place(to).is_closed; };
  graph_.for_each_beside(from, is_wanted, [&](Number to, const RunGraph::Step& step, int low, int high) {
    const double height = std::min(std::max(here, low + 0.5), high + 0.5);
    const bool is_diagonal = step.dx != 0 && step.dy != 0;
    if (is_diagonal && !(opens_at(node.x + step.dx, node.y, height) && opens_at(node.x, node.y + step.dy, height))) {
      return;
    }
    relax(from, to, height, is_diagonal ? std::sqrt(2.0) : 1.0);
  });
  const RunGraph::Column column = graph_.column(node.x, node.y);
  if (from > column.first && graph_.node(from - 1).run.high + 1 == node.run.low) {
    relax(from, from - 1, node.run.low - 0.5, 0.0);
  }
  if (from + 1 < column.end && graph_.node(from + 1).run.low == node.run.high + 1) {
    relax(from, from + 1, node.run.high + 1.5, 0.0);
  }
}

void RunSearch::relax(Number from, Number to, double height, double length) {
  Place& there = place(to);
  if (there.is_closed) return;
  const Place& here = places_[from];
  const double mean = (graph_.node(from).run.cost + graph_.node(to).run.cost) / (2.0 * kUnitCost);
  const double cost = here.cost + std::hypot(length, height - here.height) * mean;
  if (cost >= there.cost) return;
  there.height = height;
  there.cost = cost;
  there.parent = from;
  open_.push(cost + weight_ * std::hypot(bounds_.leading_cost(to), height - start_height_), cost, to);
}

Vec3 RunSearch::position(Number number) {
  const RunGraph::Node& node = graph_.node(number);
  return {node.x + 0.5, node.y + 0.5, place(number).height};
}

/// A run is entered at the height at which the one before was left, seen from the goal: up and down is flown in the one
/// that is nearer to the goal.
std::vector<Vec3> RunSearch::trace(const End& start, const End& goal) {
  std::vector<Number> runs;
  for (Number n = start.run; n != RunGraph::kNone; n = place(n).parent) runs.push_back(n);
  std::reverse(runs.begin(), runs.end());
  std::vector<Vec3> out = {goal.point};
  append(position(goal.run), &out);
  for (std::size_t i = 1; i < runs.size(); ++i) {
    const Vec3 there = position(runs[i]);
    append({out.back().x(), out.back().y(), there.z()}, &out);
    append(there, &out);
  }
  append({out.back().x(), out.back().y(), start.point.z()}, &out);
  append(start.point, &out);
  std::reverse(out.begin(), out.end());
  return out;
}

}  // namespace voxnav::planning
