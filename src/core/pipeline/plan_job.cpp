// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>

#include "planning/flight_time.hpp"
#include "voxnav/pipeline/planning_manager.hpp"
#include "voxnav/planning/corridor.hpp"

namespace voxnav::pipeline {
namespace {

using geometry::Vec3;

/// If the corridor of full radius ends within this distance, it is tried again with the vehicle's own radius.
constexpr double kTightStart_m = 0.5;
/// Steps in which a way out of a tight place is measured, its longest length, and the bisections of its radius, which
/// leave less than a millimetre.
constexpr double kWayOutStep_m = 0.1;
constexpr double kLongestWayOut_m = 4.0;
constexpr int kBisections = 10;
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
  bool is_way_out = false;  ///< the vehicle is nearer to something than its own radius, and leaves that place
};

/// Returns the distance from a point to the nearest voxel that is not known to be free, up to a limit.
double room_at(const planning::OccupancyView& view, const Vec3& point, double limit_m) {
  double low = 0.0, high = limit_m;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (check_corridor(view, {point}, middle).is_safe ? low : high) = middle;
  }
  return low;
}

/// The part of a line that leads out of a place with less room than the vehicle's own radius: up to where that radius
/// fits, and nowhere nearer to anything than the vehicle is already.
SafeLength way_out(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                   const std::vector<Vec3>& line) {
  SafeLength out{0.0, room_at(view, line.front(), config.min_corridor_radius_m), {}, true};
  const double whole_m = planning::length_of(line);
  for (int step = 1; step * kWayOutStep_m < std::min(whole_m, kLongestWayOut_m); ++step) {
    const double length_m = step * kWayOutStep_m;
    const std::vector<Vec3> part = planning::cut_at_length(line, length_m);
    out.corridor = check_corridor(view, part, out.radius_m);
    if (!out.corridor.is_safe) return out;
    if (!check_corridor(view, {part.back()}, config.min_corridor_radius_m).is_safe) continue;
    out.length_m = length_m;
    return out;
  }
  return out;
}

SafeLength safe_length(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                       const std::vector<Vec3>& line) {
  SafeLength out{0.0, config.corridor_radius_m, {}};
  out.corridor = check_corridor(view, line, config.corridor_radius_m + config.trajectory_deviation_m);
  if (!out.corridor.is_safe && out.corridor.first_unsafe_m < kTightStart_m) {
    if (!check_corridor(view, {line.front()}, config.min_corridor_radius_m).is_safe) return way_out(config, view, line);
    out.radius_m = config.min_corridor_radius_m;
    out.corridor = check_corridor(view, line, config.min_corridor_radius_m);
  }
  out.length_m = out.corridor.is_safe ? out.corridor.length_m : out.corridor.first_unsafe_m - config.stop_margin_m;
  return out;
}

std::string too_short(const SafeLength& safe) {
  const Vec3& p = safe.corridor.unsafe_point;
  return text("only %.1f m are safe to fly: ", std::max(0.0, safe.length_m)) + what_is_unsafe(safe.corridor) +
         text(" at (%.1f, %.1f, %.1f)", p.x(), p.y(), p.z());
}

}  // namespace

PlanOutcome run_plan_job(const planning::PathPlanner& planner, const planning::ClearanceField& field,
                         const PlanningManagerConfig& config, const planning::OccupancyView& view,
                         const PlanTask& task) {
  PlanOutcome out;
  out.plan = planner.plan(field, task.start_O, task.goal_O);
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
  if (out.is_to_goal || (safe.length_m > 0.0 && (cut_m >= config.min_progress_m || safe.is_way_out))) {
    out.waypoints_O = cut;
  } else if (whole_m < config.min_progress_m) {
    out.problem = std::string(explain(out.plan.status)) + text(", %.1f m left", out.plan.remaining_m);
  } else {
    out.problem = too_short(safe);
  }
  return out;
}

}  // namespace voxnav::pipeline
