// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/path_ends.hpp"

#include <cmath>

#include "planning/path/ground_cover.hpp"
#include "planning/way_out.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// A goal outside the map is replaced by a cell at most this many times as far away as one that is blocked.
constexpr int kMaxDoublings = 4;

class EndFinder {
 public:
  EndFinder(RunGraph* graph, const PathPlannerConfig& config, const Vec3& start, const Vec3& goal)
      : graph_(*graph), config_(config), field_(graph->costs().field()), start_(start), goal_(goal) {
    ends_.way_out = {geometry::index_of(start, 1.0)};
    ends_.goal_cell = geometry::index_of(goal, 1.0);
  }

  PathEnds run() {
    ends_.status = leave_start();
    if (ends_.start_run == RunGraph::kNone) return ends_;
    ends_.status = judge_goal();
    if (ends_.status == PlanStatus::kComplete) {
      ends_.goal_run = graph_.find(ends_.goal_cell);
    } else if (ends_.status != PlanStatus::kGoalFenced) {
      replace_goal();
    }
    return ends_;
  }

 private:
  /// Returns whether a point violates a fence.
  bool is_fenced(const Vec3& point) const { return field_.is_fenced(point * field_.resolution_m()); }
  bool is_fenced(const Index3& cell) const { return is_fenced(geometry::center_of(cell, 1.0)); }

  PlanStatus leave_start() {
    const Index3 start = ends_.way_out.front();
    if (is_fenced(start_)) return PlanStatus::kStartFenced;
    if (!field_.bounds().contains(start)) return PlanStatus::kOutsideMap;
    ends_.start_run = graph_.find(start);
    if (ends_.start_run != RunGraph::kNone) return PlanStatus::kComplete;
    const bool is_forbidden = config_.unknown_policy == UnknownPolicy::kForbid;
    const VoxelState state = field_.state(start);
    if (state == VoxelState::kUnknown && is_forbidden) return PlanStatus::kStartUnknown;
    if (state == VoxelState::kOccupied) return PlanStatus::kStartBlocked;
    const auto may_cross = [this, is_forbidden](const Index3& voxel) {
      const VoxelState there = field_.state(voxel);
      return field_.bounds().contains(voxel) && there != VoxelState::kOccupied &&
             (there == VoxelState::kFree || !is_forbidden) && !is_fenced(voxel);
    };
    const auto is_out = [this](const Index3& voxel) { return graph_.find(voxel) != RunGraph::kNone; };
    ends_.way_out = find_way_out(start, config_.escape_distance_m / field_.resolution_m(), {may_cross, is_out});
    if (ends_.way_out.empty()) return PlanStatus::kStartBlocked;
    ends_.start_run = graph_.find(ends_.way_out.back());
    return PlanStatus::kComplete;
  }

  PlanStatus judge_goal() {
    if (is_fenced(goal_)) return PlanStatus::kGoalFenced;
    if (!field_.bounds().contains(ends_.goal_cell)) return PlanStatus::kOutsideMap;
    const bool is_unknown = field_.state(ends_.goal_cell) == VoxelState::kUnknown;
    if (is_unknown && is_below_ground(field_, ends_.goal_cell)) return PlanStatus::kGoalBelowGround;
    if (graph_.find(ends_.goal_cell) == RunGraph::kNone) {
      const bool may_be_unknown = config_.unknown_policy == UnknownPolicy::kPenalise;
      // What an obstacle blocks stays blocked, whatever else the unknown space around the goal turns out to hold.
      const bool is_open = is_unknown && !may_be_unknown && !is_near_obstacle(ends_.goal_cell);
      return is_open ? PlanStatus::kGoalUnknown : PlanStatus::kGoalBlocked;
    }
    return may_connect(ends_.goal_cell) ? PlanStatus::kComplete : PlanStatus::kGoalEnclosed;
  }

  /// Whether an occupied voxel is nearer to a cell than the distance to be kept.
  bool is_near_obstacle(const Index3& cell) const {
    const ClearanceBlock* block = field_.block_of(cell);
    if (block == nullptr || block->to_occupied == nullptr) return false;
    const int offset = geometry::offset_in_block(cell);
    const int squared = (*block->to_occupied)[geometry::kBlockSide * (offset % kColumns) + offset / kColumns];
    return 0.5 * std::sqrt(static_cast<double>(squared)) < field_.clearance_m() / field_.resolution_m();
  }

  /// False only if the labels of the field say that there is no way.
  bool may_connect(const Index3& voxel) const {
    const bool is_known_only = config_.unknown_policy == UnknownPolicy::kForbid;
    if (!is_known_only && !field_.config().unknown_is_flyable) return true;
    return field_.component(ends_.way_out.back()) == field_.component(voxel);
  }

  /// Towards places that the map does not hold yet the vehicle flies as far as it can, beside others only to near them.
  void replace_goal() {
    const bool is_beyond = ends_.status == PlanStatus::kOutsideMap || ends_.status == PlanStatus::kGoalUnknown;
    double radius = config_.goal_search_radius_m / field_.resolution_m();
    for (int i = 0; i <= (is_beyond ? kMaxDoublings : 0) && !ends_.is_substitute; ++i, radius *= 2.0) {
      take_nearest(radius);
    }
  }

  /// Takes the nearest cell to the goal within a radius that may be entered and is connected with the start.
  void take_nearest(double radius) {
    const Vec3 low = geometry::center_of(field_.bounds().low, 1.0),
               high = geometry::center_of(field_.bounds().high, 1.0);
    const Index3 center = geometry::index_of(goal_.cwiseMax(low).cwiseMin(high), 1.0);
    double best_squared = radius * radius;
    const int reach = static_cast<int>(radius);
    for (int y = -reach; y <= reach; ++y) {
      for (int x = -reach; x <= reach; ++x) {
        const double flat = x * x + y * y;
        if (flat > best_squared) continue;
        const RunGraph::Column column = graph_.column(center.x + x, center.y + y);
        for (RunGraph::Number n = column.first; n < column.end; ++n) {
          const CellRun& run = graph_.node(n).run;
          const Index3 cell{center.x + x, center.y + y, std::min(std::max(center.z, run.low), run.high)};
          const double squared = flat + std::pow(cell.z - center.z, 2);
          if (squared > best_squared || (ends_.is_substitute && squared == best_squared)) continue;
          if (!may_connect(cell) || is_fenced(cell)) continue;
          ends_.goal_cell = cell;
          ends_.goal_run = n;
          ends_.is_substitute = true;
          best_squared = squared;
        }
      }
    }
  }

  RunGraph& graph_;
  const PathPlannerConfig& config_;
  const ClearanceField::Impl& field_;
  Vec3 start_;
  Vec3 goal_;
  PathEnds ends_;
};

}  // namespace

PathEnds find_ends(RunGraph* graph, const PathPlannerConfig& config, const Vec3& start, const Vec3& goal) {
  return EndFinder(graph, config, start, goal).run();
}

}  // namespace voxnav::planning
