// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cstdio>
#include <stdexcept>

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
/// Ends of a known way this near to the start and the goal are moved there, instead of being flown through.
constexpr double kSamePlace_m = 0.1;

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

/// Cuts the path of the plan to what may be flown of it.
void cut_path(const PlanningManagerConfig& config, const planning::OccupancyView& view, const PlanTask& task,
              PlanOutcome* outcome) {
  PlanOutcome& out = *outcome;
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
}

/// Returns the rest of a line from its point that is nearest to a place on, which is the first of several.
std::vector<Vec3> rest_from(const std::vector<Vec3>& line, const Vec3& place) {
  std::vector<Vec3> out = {line.front()};
  double nearest_m = (line.front() - place).norm();
  std::size_t next = 1;
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Vec3 along = line[i] - line[i - 1];
    const double share = along.dot(place - line[i - 1]) / std::max(along.squaredNorm(), 1e-12);
    const Vec3 point = line[i - 1] + std::clamp(share, 0.0, 1.0) * along;
    if ((point - place).norm() >= nearest_m) continue;
    nearest_m = (point - place).norm();
    out.front() = point;
    next = i;
  }
  out.insert(out.end(), line.begin() + static_cast<std::ptrdiff_t>(next), line.end());
  return out;
}

}  // namespace

PlanOutcome run_plan_job(const planning::PathPlanner& planner, const planning::ClearanceField& field,
                         const PlanningManagerConfig& config, const planning::OccupancyView& view,
                         const PlanTask& task) {
  PlanOutcome out;
  out.plan = planner.plan(field, task.start_O, task.goal_O);
  if (out.plan.path.empty()) {
    out.problem = explain(out.plan.status);
  } else {
    cut_path(config, view, task, &out);
  }
  return out;
}

PlanOutcome run_way_job(const PlanningManagerConfig& config, const planning::OccupancyView& view, const PlanTask& task,
                        const std::vector<Vec3>& way_O) {
  if (way_O.empty()) throw std::invalid_argument("a way needs places");
  PlanOutcome out;
  out.is_known_way = true;
  out.plan.status = planning::PlanStatus::kComplete;
  out.plan.path = rest_from(way_O, task.start_O);
  if ((out.plan.path.front() - task.start_O).norm() > kSamePlace_m) {
    out.plan.path.insert(out.plan.path.begin(), task.start_O);
  }
  if ((out.plan.path.back() - task.goal_O).norm() > kSamePlace_m) out.plan.path.push_back(task.goal_O);
  out.plan.length_m = planning::length_of(out.plan.path);
  cut_path(config, view, task, &out);
  return out;
}

}  // namespace voxnav::pipeline
