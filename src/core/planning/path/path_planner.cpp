// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/path_planner.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

#include "planning/path/any_angle_search.hpp"
#include "planning/path/shorten.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;
using geometry::Vec3;
using Number = RunGraph::Number;

/// Start and goal must lie within this many cells of the origin: farther ones exceed the range of a cell's index.
constexpr double kMaxCells = 1e9;

/// One call of plan(), in voxel edges.
class PathSearch {
 public:
  PathSearch(const ClearanceField& field, const PathPlannerConfig& config, const Vec3& start, const Vec3& goal)
      : field_(field.impl()),
        config_(config),
        resolution_m_(field.resolution_m()),
        costs_(field, config, start),
        graph_(&costs_, static_cast<std::size_t>(config.max_memory_mib * 0.5 * 1048576.0)),
        start_(start / resolution_m_),
        goal_(goal / resolution_m_),
        start_cell_(geometry::index_of(start_, 1.0)),
        goal_cell_(geometry::index_of(goal_, 1.0)) {
    budget_.expansions_left = static_cast<std::uint64_t>(config.max_expansions);
    budget_.max_bytes = static_cast<std::size_t>(config.max_memory_mib * 1048576.0);
  }

  AnyAnglePlan run() {
    if (!check_start()) return std::move(result_);
    check_goal();
    if (goal_run_ != RunGraph::kNone) search();
    result_.is_partial = !result_.path.empty() && result_.status != PlanStatus::kComplete;
    result_.remaining_m =
        ((result_.path.empty() ? start_ * resolution_m_ : result_.path.back()) - goal_ * resolution_m_).norm();
    return std::move(result_);
  }

 private:
  bool refuse(PlanStatus status) {
    result_.status = status;
    return false;
  }

  VoxelState state(const Index3& voxel) const {
    const ClearanceBlock* block = field_.block_of(voxel);
    return block == nullptr ? VoxelState::kUnknown : block->states.get(geometry::offset_in_block(voxel));
  }

  bool check_start() {
    if (!field_.bounds().contains(start_cell_)) return refuse(PlanStatus::kOutsideMap);
    start_run_ = graph_.find(start_cell_);
    if (start_run_ != RunGraph::kNone) return true;
    const bool is_unknown = state(start_cell_) == VoxelState::kUnknown;
    return refuse(is_unknown && config_.unknown_policy != UnknownPolicy::kPenalise ? PlanStatus::kStartUnknown
                                                                                   : PlanStatus::kStartBlocked);
  }

  /// Finds the run of the goal, or of the nearest cell to it that may be reached, and why the goal itself may not.
  void check_goal() {
    result_.status = PlanStatus::kComplete;
    const bool is_inside = field_.bounds().contains(goal_cell_);
    if (is_inside) goal_run_ = graph_.find(goal_cell_);
    const bool is_reachable = goal_run_ != RunGraph::kNone && may_connect(goal_cell_);
    if (is_reachable) return;
    result_.lower_bound_m = std::numeric_limits<double>::infinity();
    if (goal_run_ != RunGraph::kNone) {
      result_.status = PlanStatus::kPartialBlocked;
    } else if (!is_inside) {
      result_.status = PlanStatus::kOutsideMap;
    } else {
      const bool is_unknown = state(goal_cell_) == VoxelState::kUnknown;
      const bool may_be_unknown = config_.unknown_policy == UnknownPolicy::kPenalise;
      result_.status = is_unknown && !may_be_unknown ? PlanStatus::kGoalUnknown : PlanStatus::kGoalBlocked;
    }
    goal_run_ = RunGraph::kNone;
    const auto substitute = nearest_connected();
    if (!substitute) return;
    goal_run_ = graph_.find(*substitute);
    end_ = geometry::center_of(*substitute, 1.0);
  }

  /// False only if the labels of the field say that there is no way.
  bool may_connect(const Index3& voxel) const {
    const bool is_known_only = config_.unknown_policy == UnknownPolicy::kForbid;
    if (!is_known_only && !field_.config().unknown_is_flyable) return true;
    const std::uint32_t a = field_.component(start_cell_), b = field_.component(voxel);
    return a == b;
  }

  /// The nearest cell to the goal within goal_search_radius_m that may be entered and is connected with the start.
  std::optional<Index3> nearest_connected() {
    const VoxelBox& bounds = field_.bounds();
    const Vec3 low = geometry::center_of(bounds.low, 1.0), high = geometry::center_of(bounds.high, 1.0);
    const Index3 center = geometry::index_of(goal_.cwiseMax(low).cwiseMin(high), 1.0);
    const double radius = config_.goal_search_radius_m / resolution_m_;
    std::optional<Index3> best;
    double best_squared = radius * radius;
    const int reach = static_cast<int>(radius);
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const double flat = x * x + y * y;
        if (flat > best_squared) continue;
        const RunGraph::Column column = graph_.column(center.x + x, center.y + y);
        for (Number n = column.first; n < column.end; ++n) {
          const CellRun& run = graph_.node(n).run;
          const Index3 cell{center.x + x, center.y + y, std::min(std::max(center.z, run.low), run.high)};
          const double squared = flat + std::pow(cell.z - center.z, 2);
          if (squared > best_squared || (best && squared == best_squared) || !may_connect(cell)) continue;
          best = cell;
          best_squared = squared;
        }
      }
    }
    return best;
  }

  void search() {
    BoundSearch bounds(&graph_, goal_run_);
    const BoundSearch::End end = bounds.run(start_run_, &budget_);
    result_.expansions = bounds.expansions();
    if (end == BoundSearch::End::kGoal) {
      const double straight = (geometry::center_of(start_cell_, 1.0) - geometry::center_of(goal_cell_, 1.0)).norm();
      if (result_.status == PlanStatus::kComplete) {
        result_.lower_bound_m = std::max(bounds.bound(goal_run_), straight) * resolution_m_;
      }
      find_path(bounds, goal_run_);
      return;
    }
    const bool is_limit = end == BoundSearch::End::kLimit;
    if (result_.status == PlanStatus::kComplete) {
      result_.status = is_limit ? PlanStatus::kPartialLimit : PlanStatus::kPartialBlocked;
      if (!is_limit) result_.lower_bound_m = std::numeric_limits<double>::infinity();
    }
    lead_near(bounds);
  }

  /// Plans to the expanded run that is nearest to a goal which was not reached.
  void lead_near(const BoundSearch& searched) {
    const Number nearest = searched.nearest_to(goal_);
    if (nearest == RunGraph::kNone || nearest == start_run_) {
      if (result_.status == PlanStatus::kPartialBlocked) result_.status = PlanStatus::kNoPath;
      return;
    }
    const RunGraph::Node node = graph_.node(nearest);
    end_ = Vec3(node.x + 0.5, node.y + 0.5, std::min(std::max(goal_.z(), node.run.low + 0.5), node.run.high + 0.5));
    budget_.expansions_left = static_cast<std::uint64_t>(config_.max_expansions);
    BoundSearch bounds(&graph_, nearest);
    const BoundSearch::End end = bounds.run(start_run_, &budget_);
    result_.expansions += bounds.expansions();
    if (end == BoundSearch::End::kGoal) find_path(bounds, nearest);
  }

  void find_path(const BoundSearch& bounds, Number goal) {
    const SegmentClearance clearance(field_, field_.clearance_m() / resolution_m_);
    const Vec3 first = end_point(start_, clearance);
    const Vec3 last = end_ ? *end_ : end_point(goal_, clearance);
    std::vector<Vec3> sights = {first, last};
    std::size_t bytes = bounds.memory_bytes();
    if (goal != start_run_) {
      AnyAngleSearch search(&graph_, &bounds, first);
      sights = search.run(start_run_, goal, last, &budget_);
      result_.expansions += search.expansions();
      bytes += search.memory_bytes();
    }
    result_.memory_bytes = graph_.memory_bytes() + bytes;
    if (sights.empty()) {
      const bool is_limit = budget_.expansions_left == 0 || result_.memory_bytes > budget_.max_bytes;
      if (result_.status == PlanStatus::kComplete) {
        result_.status = is_limit ? PlanStatus::kPartialLimit : PlanStatus::kNoPath;
      }
      return;
    }
    PathShortening shortening(&graph_, &clearance, static_cast<std::uint64_t>(config_.max_shortening_checks));
    const std::vector<Vec3> path = shortening.run(sights);
    result_.cost_m = shortening.cost_of(path) * resolution_m_;
    for (const Vec3& point : path) result_.path.push_back(point * resolution_m_);
    for (std::size_t i = 1; i < path.size(); ++i) result_.length_m += (path[i] - path[i - 1]).norm() * resolution_m_;
  }

  /// The point itself, or the centre of its cell if the way between them is not clear.
  static Vec3 end_point(const Vec3& point, const SegmentClearance& clearance) {
    const Vec3 center = geometry::center_of(geometry::index_of(point, 1.0), 1.0);
    return clearance.is_clear(point, center) ? point : center;
  }

  const ClearanceField::Impl& field_;
  const PathPlannerConfig& config_;
  double resolution_m_;
  RunCosts costs_;
  RunGraph graph_;
  Vec3 start_;
  Vec3 goal_;
  Index3 start_cell_;
  Index3 goal_cell_;
  Number start_run_ = RunGraph::kNone;
  Number goal_run_ = RunGraph::kNone;
  std::optional<Vec3> end_;  ///< end of the path if it is not the goal
  WorkBudget budget_;
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
