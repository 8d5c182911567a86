// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>

#include "voxnav/pipeline/planning_manager.hpp"
#include "voxnav/planning/corridor.hpp"

namespace voxnav::pipeline {
namespace {

std::string place_text(const planning::CorridorResult& corridor) {
  char buffer[160];
  const geometry::Vec3& p = corridor.unsafe_point;
  std::snprintf(buffer, sizeof buffer, "%s%s in %.1f m at (%.1f, %.1f, %.1f)",
                corridor.fence ? "" : "not known free: ", what_is_unsafe(corridor), corridor.first_unsafe_m, p.x(),
                p.y(), p.z());
  return buffer;
}

}  // namespace

SafePart safe_part(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                   const FlownTrajectory& flown) {
  const auto corridor = check_corridor(view, flown.trajectory.points_from_arc(flown.from_arc_m), flown.radius_m);
  if (corridor.is_safe) return {flown.trajectory, {}};
  SafePart out{std::nullopt, place_text(corridor)};
  const double room_m = corridor.first_unsafe_m - config.stop_margin_m;
  const double stop_arc_m = flown.from_arc_m + room_m;
  const double deceleration =
      config.deceleration_ratio *
      planning::braking_deceleration(flown.trajectory, flown.from_arc_m, stop_arc_m, flown.velocity_O, flown.limits);
  const double speed = flown.velocity_O.norm();
  if (room_m < planning::stopping_distance(speed, deceleration, config.reaction_time_s)) return out;
  out.trajectory = flown.trajectory.stopped_at(flown.from_arc_m, stop_arc_m, deceleration);
  return out;
}

}  // namespace voxnav::pipeline
