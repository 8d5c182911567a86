// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/a_star.hpp"

#include <algorithm>
#include <cmath>

#include "planning/search.hpp"
#include "planning/simplify.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;
using geometry::Vec3;

constexpr std::size_t kOpenEntryBytes = 24;

/// Start and goal must lie within this many cells of the origin: farther ones exceed the range of a cell's index.
constexpr double kMaxCells = 1e9;

SearchBudget budget_of(const AStarConfig& config, std::chrono::steady_clock::time_point begin) {
  SearchBudget budget;
  budget.deadline = begin + std::chrono::microseconds(std::llround(config.timeout_s * 1e6));
  budget.max_expansions = static_cast<std::uint64_t>(config.max_expansions);
  // A vector may need three times its size while it grows: the old storage and twice as much for the new one.
  budget.max_open = static_cast<std::size_t>(config.max_memory_mib * 0.5 * 1048576.0 / (3 * kOpenEntryBytes));
  return budget;
}

/// One call of plan(). Its steps take any start and goal: a start is left and a goal replaced if it cannot be entered.
class PlanCall {
 public:
  PlanCall(const OccupancyView& view, const AStarConfig& config, const Vec3& start, const Vec3& goal)
      : begin_(std::chrono::steady_clock::now()),
        view_(view),
        config_(config),
        budget_(budget_of(config, begin_)),
        resolution_m_(view.resolution_m()),
        start_(start),
        goal_(goal),
        costs_(view, config, start),
        space_(&costs_, static_cast<std::uint64_t>(config.max_memory_mib * 0.5 * 1048576.0)),
        start_cell_(geometry::index_of(start, resolution_m_)),
        goal_cell_(geometry::index_of(goal, resolution_m_)) {}

  PlanResult run() {
    if (!leave_start()) return finish();
    if (costs_.is_fenced(goal_)) {
      refuse(PlanStatus::kGoalFenced);
      return finish();
    }
    choose_goal();
    SearchOutcome outcome = search(&space_, way_out_.back(), goal_cell_, config_.heuristic_weight, budget_);
    result_.expansions = outcome.expansions;
    open_bytes_ = outcome.open_bytes;
    set_status(outcome);
    set_path(outcome);
    return finish();
  }

 private:
  bool is_enterable(const Index3& voxel) {
    CellRef cell;
    return space_.locate(voxel, &cell) && space_.cost(cell) != 0;
  }

  /// Fills way_out_ with the cells from the start to the first cell that may be entered.
  bool leave_start() {
    if (costs_.is_fenced(start_)) return refuse(PlanStatus::kStartFenced);
    if (!costs_.is_inside(start_cell_)) return refuse(PlanStatus::kOutsideMap);
    const bool is_forbidden = config_.unknown_policy == UnknownPolicy::kForbid;
    const VoxelState state = costs_.state(start_cell_);
    if (state == VoxelState::kOccupied) return refuse(PlanStatus::kStartBlocked);
    if (state == VoxelState::kUnknown && is_forbidden) return refuse(PlanStatus::kStartUnknown);
    way_out_ = {start_cell_};
    if (is_enterable(start_cell_)) return true;
    const double radius = config_.escape_distance_m / resolution_m_;
    way_out_ = escape(&space_, &costs_, start_cell_, radius, !is_forbidden, budget_);
    return way_out_.empty() ? refuse(PlanStatus::kStartBlocked) : true;
  }

  bool refuse(PlanStatus status) {
    result_.status = status;
    return false;
  }

  /// Replaces a goal that may not be entered by a cell near it, and records why the goal cannot be reached.
  void choose_goal() {
    goal_problem_ = PlanStatus::kComplete;
    if (!costs_.is_inside(goal_cell_)) {
      goal_problem_ = PlanStatus::kOutsideMap;
      const geometry::Aabb box = view_.bounds().padded(-0.5 * resolution_m_);
      goal_cell_ = geometry::index_of(goal_.cwiseMax(box.min).cwiseMin(box.max), resolution_m_);
    }
    if (is_enterable(goal_cell_)) return;
    if (goal_problem_ == PlanStatus::kComplete) {
      const bool is_unknown =
          costs_.state(goal_cell_) == VoxelState::kUnknown && config_.unknown_policy != UnknownPolicy::kPenalise;
      goal_problem_ = is_unknown ? PlanStatus::kGoalUnknown : PlanStatus::kGoalBlocked;
    }
    Index3 substitute;
    const double radius = config_.goal_search_radius_m / resolution_m_;
    if (nearest_enterable(&space_, goal_cell_, radius, budget_, &substitute)) goal_cell_ = substitute;
  }

  void set_status(const SearchOutcome& outcome) {
    const bool has_moved = outcome.cells.size() + way_out_.size() > 2;
    if (goal_problem_ != PlanStatus::kComplete) {
      result_.status = goal_problem_;
    } else if (outcome.end == SearchEnd::kGoal) {
      result_.status = PlanStatus::kComplete;
    } else if (outcome.end == SearchEnd::kTimeout) {
      result_.status = PlanStatus::kPartialTimeout;
    } else if (outcome.end == SearchEnd::kLimit) {
      result_.status = PlanStatus::kPartialLimit;
    } else {
      result_.status = has_moved ? PlanStatus::kPartialBlocked : PlanStatus::kNoPath;
    }
  }

  void set_path(const SearchOutcome& outcome) {
    std::vector<Index3> cells = outcome.cells;
    if (config_.simplify) {
      ShortcutRules rules;
      rules.clearance_m = config_.safety_distance_m - view_.grown_by_m();
      rules.known_m = config_.unknown_policy == UnknownPolicy::kOptimisticFar ? config_.known_distance_m : 0.0;
      rules.known_range_m = config_.optimistic_range_m;
      rules.start = start_;
      cells = simplify(&space_, view_, cells, rules, budget_);
    }
    cells.insert(cells.begin(), way_out_.begin(), way_out_.end() - (cells.empty() ? 0 : 1));
    for (const Index3& cell : cells) result_.path.push_back(geometry::center_of(cell, resolution_m_));
    result_.cost_m = outcome.cost_cells * resolution_m_;
    for (std::size_t i = 1; i < way_out_.size(); ++i) {
      result_.cost_m +=
          (geometry::center_of(way_out_[i], resolution_m_) - geometry::center_of(way_out_[i - 1], resolution_m_))
              .norm();
    }
    result_.remaining_m = (result_.path.back() - goal_).norm();
    result_.is_partial = result_.status != PlanStatus::kComplete;
  }

  PlanResult finish() {
    result_.memory_bytes = space_.memory_bytes() + open_bytes_;
    result_.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count();
    return std::move(result_);
  }

  std::chrono::steady_clock::time_point begin_;
  const OccupancyView& view_;
  const AStarConfig& config_;
  SearchBudget budget_;
  double resolution_m_;
  Vec3 start_;
  Vec3 goal_;
  CellCosts costs_;
  SearchSpace space_;
  Index3 start_cell_;
  Index3 goal_cell_;
  PlanStatus goal_problem_ = PlanStatus::kComplete;
  std::vector<Index3> way_out_;
  std::size_t open_bytes_ = 0;
  PlanResult result_;
};

}  // namespace

AStarPlanner::AStarPlanner(const AStarConfig& config) : config_(base::checked(config)) {}

PlanResult AStarPlanner::plan(const OccupancyView& view, const Vec3& start, const Vec3& goal) const {
  if (!start.allFinite() || !goal.allFinite()) return {};
  const Vec3 limit = Vec3::Constant(kMaxCells * view.resolution_m());
  return PlanCall(view, config_, start.cwiseMin(limit).cwiseMax(-limit), goal.cwiseMin(limit).cwiseMax(-limit)).run();
}

}  // namespace voxnav::planning
