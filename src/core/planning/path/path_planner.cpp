// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/path_planner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "planning/path/any_angle_search.hpp"
#include "planning/path/lattice_search.hpp"
#include "planning/path/path_ends.hpp"
#include "planning/path/run_search.hpp"
#include "planning/path/shorten.hpp"

namespace voxnav::planning {
namespace {

using geometry::Vec3;
using Number = RunGraph::Number;

/// Start and goal must lie within this many cells of the origin: farther ones exceed the range of a cell's index.
constexpr double kMaxCells = 1e9;

/// The share of what the bound allows that a quick search over runs may spend; the rest is for making a path of the
/// runs.
constexpr double kQuickShare = 0.6;

/// One call of plan(), in voxel edges.
class PathSearch {
 public:
  PathSearch(const ClearanceField& field, const PathPlannerConfig& config, const Vec3& start, const Vec3& goal)
      : field_(field.impl()),
        config_(config),
        resolution_m_(field.resolution_m()),
        costs_(field, config, start),
        graph_(&costs_, static_cast<std::size_t>(config.max_memory_mib * 0.5 * 1048576.0)),
        clearance_(field_, field_.clearance_m() / resolution_m_, known_ball(config, start, resolution_m_)),
        start_(start / resolution_m_),
        goal_(goal / resolution_m_),
        ends_(find_ends(&graph_, config, start_, goal_)) {
    budget_.expansions_left = static_cast<std::uint64_t>(config.max_expansions);
    budget_.max_bytes = static_cast<std::size_t>(config.max_memory_mib * 1048576.0);
    result_.status = ends_.status;
  }

  AnyAnglePlan run() {
    if (ends_.status != PlanStatus::kComplete) result_.lower_bound_m = std::numeric_limits<double>::infinity();
    if (ends_.has_path()) search();
    result_.is_partial = !result_.path.empty() && result_.status != PlanStatus::kComplete;
    result_.remaining_m =
        ((result_.path.empty() ? start_ * resolution_m_ : result_.path.back()) - goal_ * resolution_m_).norm();
    return std::move(result_);
  }

 private:
  static KnownBall known_ball(const PathPlannerConfig& config, const Vec3& start, double resolution_m) {
    const double distance_m = config.unknown_policy == UnknownPolicy::kOptimisticFar ? config.known_distance_m : 0.0;
    return {start / resolution_m, config.optimistic_range_m / resolution_m, distance_m / resolution_m};
  }

  void search() {
    if (config_.quick && ends_.status == PlanStatus::kComplete && search_quickly()) return finish();
    // What a quick search has spent in vain must not end the thorough one.
    budget_.expansions_left = static_cast<std::uint64_t>(config_.max_expansions);
    BoundSearch bounds(&graph_, ends_.goal_run);
    const BoundSearch::End end = bounds.run(ends_.start_run, &budget_);
    result_.expansions += bounds.expansions();
    if (end == BoundSearch::End::kGoal) {
      if (result_.status == PlanStatus::kComplete) set_lower_bound(bounds.goal_cost());
      find_path(bounds);
      return;
    }
    const bool is_limit = end == BoundSearch::End::kLimit;
    if (result_.status == PlanStatus::kComplete) {
      result_.status = is_limit ? PlanStatus::kPartialLimit : PlanStatus::kPartialBlocked;
      if (!is_limit) result_.lower_bound_m = std::numeric_limits<double>::infinity();
    }
    lead_near(bounds);
  }

  /// Takes the first path that a weighted search finds; returns false if it misses the bound.
  bool search_quickly() {
    const double weight = 1.0 + kQuickShare * (config_.suboptimality_bound - 1.0);
    BoundSearch bounds(&graph_, ends_.goal_run, weight);
    const BoundSearch::End end = bounds.run(ends_.start_run, &budget_);
    result_.expansions += bounds.expansions();
    if (end != BoundSearch::End::kGoal) return false;
    set_lower_bound(bounds.goal_cost() / weight);
    RunSearch search(&graph_, &bounds, config_.suboptimality_bound);
    consider(search.run({ends_.start_run, first_point()}, {ends_.goal_run, last_point()}, &budget_));
    result_.expansions += search.expansions();
    result_.memory_bytes = graph_.memory_bytes() + bounds.memory_bytes() + search.memory_bytes();
    return !path_.empty() && cost_ * resolution_m_ <= config_.suboptimality_bound * result_.lower_bound_m;
  }

  /// @param over_runs  no path over runs costs less
  void set_lower_bound(double over_runs) {
    const double straight = (center(ends_.way_out.back()) - center(ends_.goal_cell)).norm();
    result_.lower_bound_m = std::max(over_runs, straight) * resolution_m_;
  }

  /// Plans to the expanded run that is nearest to a goal which was not reached.
  void lead_near(const BoundSearch& searched) {
    const Number nearest = searched.nearest_to(goal_);
    if (nearest == RunGraph::kNone || nearest == ends_.start_run) {
      if (result_.status == PlanStatus::kPartialBlocked) result_.status = PlanStatus::kNoPath;
      return;
    }
    const RunGraph::Node node = graph_.node(nearest);
    const int height = static_cast<int>(std::floor(goal_.z()));
    ends_.goal_cell = {node.x, node.y, std::min(std::max(height, node.run.low), node.run.high)};
    ends_.goal_run = nearest;
    ends_.is_substitute = true;
    // Where the first search spent all that it had, the way to its best place still has to be found.
    budget_.expansions_left = static_cast<std::uint64_t>(config_.max_expansions);
    find_path(searched);
  }

  Vec3 first_point() const { return ends_.way_out.size() > 1 ? center(ends_.way_out.back()) : end_point(start_); }
  Vec3 last_point() const { return ends_.is_substitute ? center(ends_.goal_cell) : end_point(goal_); }

  void find_path(const BoundSearch& bounds) {
    const Vec3 first = first_point(), last = last_point();
    const double bound = bounds.bound(ends_.goal_run) * config_.suboptimality_bound;
    consider(any_angle(bounds, first, last));
    if (path_.empty() || cost_ > bound) consider(over_lattice(bounds, first, last));
    result_.memory_bytes += graph_.memory_bytes() + bounds.memory_bytes();
    if (!path_.empty()) return finish();
    const bool is_limit = budget_.expansions_left == 0 || result_.memory_bytes > budget_.max_bytes;
    if (result_.status == PlanStatus::kComplete) {
      result_.status = is_limit ? PlanStatus::kPartialLimit : PlanStatus::kNoPath;
    }
  }

  std::vector<Vec3> any_angle(const BoundSearch& bounds, const Vec3& first, const Vec3& last) {
    if (ends_.goal_run == ends_.start_run) return {first, last};
    AnyAngleSearch search(&graph_, &bounds, first);
    std::vector<Vec3> sights = search.run(ends_.start_run, ends_.goal_run, last, &budget_);
    result_.expansions += search.expansions();
    result_.memory_bytes = std::max<std::uint64_t>(result_.memory_bytes, search.memory_bytes());
    return sights;
  }

  std::vector<Vec3> over_lattice(const BoundSearch& bounds, const Vec3& first, const Vec3& last) {
    LatticeSearch search(&graph_, &bounds, config_.suboptimality_bound);
    std::vector<Vec3> cells = search.run(ends_.way_out.back(), ends_.goal_cell, &budget_);
    result_.expansions += search.expansions();
    result_.memory_bytes = std::max<std::uint64_t>(result_.memory_bytes, search.memory_bytes());
    if (cells.empty()) return cells;
    if (cells.front() != first) cells.insert(cells.begin(), first);
    if (cells.back() != last) cells.push_back(last);
    return cells;
  }

  /// Shortens a path, and takes it if it is cheaper than the one before.
  void consider(const std::vector<Vec3>& points) {
    if (points.empty()) return;
    PathShortening shortening(&graph_, &clearance_, static_cast<std::uint64_t>(config_.max_shortening_checks));
    std::vector<Vec3> path = shortening.run(points);
    const double cost = shortening.cost_of(path);
    if (!path_.empty() && cost >= cost_) return;
    path_ = std::move(path);
    cost_ = cost;
  }

  /// Puts the way out of a blocked start before the path. The cells of it cost their length alone.
  void finish() {
    std::vector<Vec3> before;
    if (ends_.way_out.size() > 1) before.push_back(start_);
    for (std::size_t i = 1; i + 1 < ends_.way_out.size(); ++i) before.push_back(center(ends_.way_out[i]));
    for (std::size_t i = 0; i < before.size(); ++i) {
      cost_ += ((i + 1 < before.size() ? before[i + 1] : path_.front()) - before[i]).norm();
    }
    path_.insert(path_.begin(), before.begin(), before.end());
    result_.cost_m = cost_ * resolution_m_;
    for (const Vec3& point : path_) result_.path.emplace_back(point * resolution_m_);
    for (std::size_t i = 1; i < path_.size(); ++i) result_.length_m += (path_[i] - path_[i - 1]).norm() * resolution_m_;
  }

  static Vec3 center(const geometry::Index3& cell) { return geometry::center_of(cell, 1.0); }

  /// The point itself, or the centre of its cell if the way between them is not clear.
  Vec3 end_point(const Vec3& point) const {
    const Vec3 middle = center(geometry::index_of(point, 1.0));
    return clearance_.is_clear(point, middle) ? point : middle;
  }

  const ClearanceField::Impl& field_;
  const PathPlannerConfig& config_;
  double resolution_m_;
  RunCosts costs_;
  RunGraph graph_;
  SegmentClearance clearance_;
  Vec3 start_;
  Vec3 goal_;
  PathEnds ends_;
  WorkBudget budget_;
  std::vector<Vec3> path_;  ///< the cheapest so far
  double cost_ = 0.0;
  AnyAnglePlan result_;
};

}  // namespace

PathPlanner::PathPlanner(const PathPlannerConfig& config) : config_(base::checked(config)) {}

AnyAnglePlan PathPlanner::plan(const ClearanceField& field, const Vec3& start, const Vec3& goal) const {
  const auto begin = std::chrono::steady_clock::now();
  AnyAnglePlan out;
  if (!start.allFinite() || !goal.allFinite()) return out;
  if (field.resolution_m() == 0.0) {
    out.status = PlanStatus::kOutsideMap;
    return out;
  }
  const Vec3 limit = Vec3::Constant(kMaxCells * field.resolution_m());
  out = PathSearch(field, config_, start.cwiseMin(limit).cwiseMax(-limit), goal.cwiseMin(limit).cwiseMax(-limit)).run();
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  return out;
}

}  // namespace voxnav::planning
