// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "voxnav/base/config.hpp"
#include "voxnav/base/time.hpp"
#include "voxnav/planning/clearance_field.hpp"
#include "voxnav/planning/occupancy_view.hpp"
#include "voxnav/planning/path_planner.hpp"
#include "voxnav/planning/trajectory.hpp"

namespace voxnav::pipeline {

struct PlanningManagerConfig {
  double planning_budget_s = 0.3;
  double generation_budget_s = 0.5;
  double max_flight_time_s = 15.0;
  double replan_interval_s = 1.5;
  double retry_interval_s = 0.5;
  double corridor_radius_m = 0.7;
  double min_corridor_radius_m = 0.5;
  double trajectory_deviation_m = 0.2;
  double replan_deviation_m = 1.0;
  double brake_deviation_m = 3.5;
  double stop_margin_m = 0.4;
  double reaction_time_s = 0.4;
  double deceleration_ratio = 0.7;
  double goal_tolerance_m = 0.8;
  double rest_speed_mps = 0.3;
  double min_progress_m = 1.0;
  double stuck_time_s = 25.0;
  int max_dead_ends = 20;
  double odometry_timeout_s = 1.0;
  double map_timeout_s = 1.5;
  double correction_timeout_s = 3.0;
  double tracker_timeout_s = 1.0;
  double diagnostics_timeout_s = 3.0;
  double constraints_timeout_s = 5.0;
  double job_timeout_s = 4.0;

  template <class V>
  static void fields(V&& v) {
    using C = PlanningManagerConfig;
    const auto seconds = base::in(0.05, 60.0);
    v("planning_budget_s", &C::planning_budget_s, seconds, "s", "time a search may take when planning ahead in flight");
    v("generation_budget_s", &C::generation_budget_s, seconds, "s", "time the trajectory generator may take");
    v("max_flight_time_s", &C::max_flight_time_s, base::in(1.0, 120.0), "s",
      "trajectories are cut to this flight time");
    v("replan_interval_s", &C::replan_interval_s, seconds, "s",
      "age of a trajectory at which the next plan starts, or sooner so that it is there before this one brakes");
    v("retry_interval_s", &C::retry_interval_s, seconds, "s", "pause after a plan that failed");
    v("corridor_radius_m", &C::corridor_radius_m, base::in(0.1, 5.0), "m",
      "known free space that must surround the flown trajectory: vehicle radius and margin");
    v("min_corridor_radius_m", &C::min_corridor_radius_m, base::in(0.1, 5.0), "m",
      "radius for leaving a place where the full one does not fit: the vehicle's own");
    v("trajectory_deviation_m", &C::trajectory_deviation_m, base::in(0.02, 2.0), "m",
      "how far the generator may leave the waypoints; plans keep this much more room");
    v("replan_deviation_m", &C::replan_deviation_m, base::in(0.1, 20.0), "m",
      "a vehicle, or a place that the tracker predicts, farther from the trajectory starts a new plan from there");
    v("brake_deviation_m", &C::brake_deviation_m, base::in(0.1, 50.0), "m",
      "a vehicle farther from its trajectory brakes; the mutual avoidance of MRS climbs 3 m");
    v("stop_margin_m", &C::stop_margin_m, base::in(0.0, 5.0), "m",
      "distance before unsafe space at which the vehicle comes to rest");
    v("reaction_time_s", &C::reaction_time_s, base::in(0.0, 5.0), "s", "time until braking takes effect");
    v("deceleration_ratio", &C::deceleration_ratio, base::in(0.1, 1.0), "",
      "share of the allowed acceleration for braking");
    v("goal_tolerance_m", &C::goal_tolerance_m, base::in(0.1, 10.0), "m",
      "the goal is reached this near to it, at rest");
    v("rest_speed_mps", &C::rest_speed_mps, base::in(0.01, 2.0), "m/s", "slower counts as at rest");
    v("min_progress_m", &C::min_progress_m, base::in(0.1, 20.0), "m",
      "shorter trajectories are not flown unless they end at the goal; new ones must lead this much nearer to it");
    v("stuck_time_s", &C::stuck_time_s, base::in(1.0, 600.0), "s",
      "the goal is given up after this long without a shorter way left to it");
    v("max_dead_ends", &C::max_dead_ends, base::in(1, 1000), "",
      "the goal is given up after this many ways that turned out to be closed");
    v("odometry_timeout_s", &C::odometry_timeout_s, seconds, "s", "older odometry is lost");
    v("map_timeout_s", &C::map_timeout_s, seconds, "s", "an older local map is lost");
    v("correction_timeout_s", &C::correction_timeout_s, base::in(0.0, 600.0), "s",
      "an older map correction (T_W_O) is lost; 0 = the first one holds for ever");
    v("tracker_timeout_s", &C::tracker_timeout_s, seconds, "s", "an older tracker command (prediction) is lost");
    v("diagnostics_timeout_s", &C::diagnostics_timeout_s, seconds, "s", "older control manager diagnostics are lost");
    v("constraints_timeout_s", &C::constraints_timeout_s, seconds, "s", "older constraints are lost");
    v("job_timeout_s", &C::job_timeout_s, seconds, "s", "a search or service that takes longer has failed");
  }
  std::vector<std::string> problems() const;
};

/// A search and what may be flown of its path.
struct PlanOutcome {
  planning::AnyAnglePlan plan;
  std::vector<geometry::Vec3> waypoints_O;  ///< from the start to a stop in known free space; empty when there is none
  bool is_to_goal = false;  ///< the last waypoint is the goal, or so near to a blocked one that it counts as reached
  double corridor_radius_m = 0.0;  ///< known free around the waypoints
  double left_m = 0.0;             ///< way from the last waypoint to the goal, as planned
  std::string problem;             ///< why there are no waypoints, for a person
  bool is_known_way = false;       ///< the path is a way that was given, not one that was searched
};

/// What is to be planned.
struct PlanTask {
  geometry::Vec3 start_O;
  geometry::Vec3 goal_O;
  planning::DynamicsLimits limits;  ///< must be valid
};

/// Searches a way on a clearance field that is up to date with the view, then cuts it: to known free space with room to
/// stop, and to the longest flight time. Where the vehicle is nearer to something than its own radius, the way leads
/// out of there first, never nearer than at the start. Takes as long as the search.
PlanOutcome run_plan_job(const planning::PathPlanner& planner, const planning::ClearanceField& field,
                         const PlanningManagerConfig& config, const planning::OccupancyView& view,
                         const PlanTask& task);

/// Cuts a given way in the same manner, from its place that is nearest to the start on. It ends at the goal.
/// @param way_O  at least one place
/// @throws std::invalid_argument for a way without places
PlanOutcome run_way_job(const PlanningManagerConfig& config, const planning::OccupancyView& view, const PlanTask& task,
                        const std::vector<geometry::Vec3>& way_O);

/// A trajectory from where the vehicle is, and what has to be known to stop on it.
struct FlownTrajectory {
  const planning::Trajectory& trajectory;
  double from_arc_m;  ///< where the vehicle is
  double radius_m;    ///< that must be known free around it
  geometry::Vec3 velocity_O;
  planning::DynamicsLimits limits;  ///< must be valid
  /// The time at which the vehicle is there. If it is not given, it is that of the sightings of the view.
  std::optional<base::StampNs> now_ns = std::nullopt;
};

/// What of a trajectory may be flown.
struct SafePart {
  /// The whole trajectory if its corridor is known free and meets nothing that moves; else as much as can be flown and
  /// stopped in, from where the vehicle is; nothing when there is no room to stop.
  std::optional<planning::Trajectory> trajectory;
  std::string problem;  ///< where the corridor is not known free, for a person; empty when it is
};

/// Where something that moves may be met: the length flown before it, and the time from now.
struct PlaceOfMeeting {
  double arc_m;
  double after_s;
};

/// Returns where a ball that flies a trajectory from now on, and rests at its end, may first touch something that
/// moves; nothing if it meets nothing within the time for which things are predicted.
std::optional<PlaceOfMeeting> place_of_meeting(const planning::OccupancyView& view,
                                               const planning::Trajectory& trajectory, base::StampNs now_ns,
                                               double radius_m);

/// Checks the corridor of a trajectory, and what it may meet there, and cuts it. A lone return counts as soon as the
/// vehicle could not stop any more if it waited for the next sweep. @param view in the frame of the trajectory
SafePart safe_part(const PlanningManagerConfig& config, const planning::OccupancyView& view,
                   const FlownTrajectory& flown);

}  // namespace voxnav::pipeline
