// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include "planning/flight_time.hpp"
#include "voxnav/pipeline/planning_manager.hpp"
#include "voxnav/planning/corridor.hpp"

namespace voxnav::pipeline {
namespace {

using containers::VoxelState;
using geometry::Vec3;

/// If the corridor of full radius ends within this distance, it is tried again with the vehicle's own radius.
constexpr double kTightStart_m = 0.5;
/// A path that ends within this share of the goal's tolerance of a blocked goal counts as reaching it; the rest of the
/// tolerance is left for tracking.
constexpr double kSubstituteShare = 0.75;

std::string text(const char* format, double a, double b = 0.0, double c = 0.0, double d = 0.0) {
  char buffer[160];
  std::snprintf(buffer, sizeof buffer, format, a, b, c, d);
  return buffer;
}

/// Returns the path with its ends at the exact start and, if it reaches it, the exact goal; it has at least two points.
std::vector<Vec3> exact_line(const planning::PlanResult& plan, const Vec3& start, const Vec3& goal) {
  std::vector<Vec3> line = plan.path;
  if (line.size() == 1) line.push_back(line.front());
  line.front() = start;
  if (plan.status == planning::PlanStatus::kComplete) line.back() = goal;
  return line;
}

struct SafeLength {
  double length_m;
  double radius_m;
  planning::CorridorResult corridor;
};

SafeLength safe_length(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                       const std::vector<Vec3>& line) {
  SafeLength out{0.0, config.corridor_radius_m, {}};
  out.corridor = check_corridor(view, line, config.corridor_radius_m + config.trajectory_deviation_m);
  if (!out.corridor.is_safe && out.corridor.first_unsafe_m < kTightStart_m) {
    out.radius_m = config.min_corridor_radius_m;
    out.corridor = check_corridor(view, line, config.min_corridor_radius_m);
  }
  out.length_m = out.corridor.is_safe ? out.corridor.length_m : out.corridor.first_unsafe_m - config.stop_margin_m;
  return out;
}

std::string too_short(const SafeLength& safe) {
  const Vec3& p = safe.corridor.unsafe_point;
  const char* format = safe.corridor.unsafe_state == VoxelState::kOccupied
                           ? "only %.1f m are safe to fly: occupied at (%.1f, %.1f, %.1f)"
                           : "only %.1f m are safe to fly: unknown at (%.1f, %.1f, %.1f)";
  return text(format, std::max(0.0, safe.length_m), p.x(), p.y(), p.z());
}

}  // namespace

PlanOutcome run_plan_job(const planning::AStarPlanner& planner, const PlanningManagerConfig& config,
                         const planning::OccupancyView& view, const PlanTask& task) {
  PlanOutcome out;
  out.plan = planner.plan(view, task.start_O, task.goal_O, task.stop);
  if (out.plan.path.empty()) {
    out.problem = explain(out.plan.status);
    return out;
  }
  const std::vector<Vec3> line = exact_line(out.plan, task.start_O, task.goal_O);
  const SafeLength safe = safe_length(config, view, line);
  const double whole_m = planning::length_of(line);
  std::vector<Vec3> cut = safe.length_m >= whole_m ? line : planning::cut_at_length(line, safe.length_m);
  cut = planning::cut_at_time(cut, task.limits, config.trajectory_deviation_m, config.max_flight_time_s);
  const double cut_m = planning::length_of(cut);
  const double end_gap_m = out.plan.status == planning::PlanStatus::kComplete ? 0.0 : out.plan.remaining_m;
  out.corridor_radius_m = safe.radius_m;
  out.is_to_goal = end_gap_m <= kSubstituteShare * config.goal_tolerance_m && cut_m >= whole_m - 1e-6;
  out.left_m = whole_m - cut_m + end_gap_m;
  if (out.is_to_goal || (cut_m >= config.min_progress_m && safe.length_m > 0.0)) {
    out.waypoints_O = cut;
  } else if (whole_m < config.min_progress_m) {
    out.problem = std::string(explain(out.plan.status)) + text(", %.1f m left", out.plan.remaining_m);
  } else {
    out.problem = too_short(safe);
  }
  return out;
}

}  // namespace voxnav::pipeline
