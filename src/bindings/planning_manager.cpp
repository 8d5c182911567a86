// SPDX-License-Identifier: BSD-3-Clause
#include "planning_manager.hpp"

#include <memory>

#include "bind_config.hpp"
#include "configs/fences_config.hpp"
#include "configs/flight_search_config.hpp"
#include "configs/home_config.hpp"
#include "configs/octomap_face_config.hpp"
#include "configs/other_uavs_config.hpp"
#include "configs/planning_node_config.hpp"
#include "configs/work_time_config.hpp"
#include "point_lists.hpp"
#include "views.hpp"
#include "voxnav/pipeline/planning_manager.hpp"

namespace voxnav::bindings {
namespace {

using namespace pipeline;  // NOLINT: this file binds that namespace
using planning::OccupancyView;
using planning::Trajectory;

using LimitValues = std::array<double, 6>;

planning::DynamicsLimits limits_of(const LimitValues& v) {
  const planning::DynamicsLimits limits{v[0], v[1], v[2], v[3], v[4], v[5]};
  if (!limits.is_valid()) throw py::value_error("limits must be six positive numbers");
  return limits;
}

void bind_trajectory(py::module_& m) {
  py::class_<Trajectory>(m, "Trajectory", "Positions at equal time steps; the vehicle is at rest at the last one.")
      .def(py::init([](const py::array& points, double dt_s) { return Trajectory(points_of(points, "points"), dt_s); }),
           py::arg("points"), py::arg("dt_s"))
      .def_property_readonly("points", [](const Trajectory& t) { return points_array(t.points()); })
      .def_property_readonly("dt_s", &Trajectory::dt_s)
      .def_property_readonly("length_m", &Trajectory::length_m)
      .def_property_readonly("duration_s", &Trajectory::duration_s)
      .def_property_readonly("braking_begins_s", &Trajectory::braking_begins_s,
                             "Time from which on it only gets slower until it rests [s].")
      .def(
          "project",
          [](const Trajectory& t, const py::object& position, double from_s, double to_s) {
            return t.project(vec3_of(position, "position"), from_s, to_s);
          },
          py::arg("position"), py::arg("from_s"), py::arg("to_s"),
          "Arc length [m] of the point nearest to a position among those passed between two times [s].")
      .def(
          "points_from_arc", [](const Trajectory& t, double arc_m) { return points_array(t.points_from_arc(arc_m)); },
          py::arg("arc_m"), "(k, 3) points from an arc length [m] on, beginning with the point at it.");
}

void bind_outcome(py::module_& m) {
  py::class_<PlanOutcome>(m, "PlanOutcome", "The result of a search, and the part of its path that may be flown.")
      .def_readonly("plan", &PlanOutcome::plan)
      .def_property_readonly(
          "status", [](const PlanOutcome& o) { return to_member(o.plan.status); }, "A PlanStatus.")
      .def_property_readonly("waypoints_O", [](const PlanOutcome& o) { return points_array(o.waypoints_O); })
      .def_readonly("is_to_goal", &PlanOutcome::is_to_goal)
      .def_readonly("corridor_radius_m", &PlanOutcome::corridor_radius_m)
      .def_readonly("left_m", &PlanOutcome::left_m)
      .def_readonly("problem", &PlanOutcome::problem)
      .def_readonly("is_known_way", &PlanOutcome::is_known_way,
                    "Whether the path is a way that was given, not one that was searched.");
}

PlanOutcome plan_job(const planning::PathPlanner& planner, const planning::ClearanceField& field,
                     const PlanningManagerConfig& config, const py::object& map, const py::object& start_O,
                     const py::object& goal_O, const LimitValues& limits) {
  const auto view = view_of(map, field.config().safety_distance_m);
  const PlanTask task{vec3_of(start_O, "start_O"), vec3_of(goal_O, "goal_O"), limits_of(limits)};
  py::gil_scoped_release release;
  return run_plan_job(planner, field, config, *view, task);
}

PlanOutcome way_job(const PlanningManagerConfig& config, const std::shared_ptr<OccupancyView>& view,
                    const py::object& start_O, const py::object& goal_O, const LimitValues& limits,
                    const py::array& way_O) {
  const PlanTask task{vec3_of(start_O, "start_O"), vec3_of(goal_O, "goal_O"), limits_of(limits)};
  const std::vector<geometry::Vec3> way = points_of(way_O, "way_O");
  py::gil_scoped_release release;
  return run_way_job(config, *view, task, way);
}

SafePart safe_part_of(const PlanningManagerConfig& config, const std::shared_ptr<OccupancyView>& view,
                      const Trajectory& trajectory, double from_arc_m, double radius_m, const py::object& velocity_O,
                      const LimitValues& values, const std::optional<double>& now_s) {
  FlownTrajectory flown{trajectory, from_arc_m, radius_m, vec3_of(velocity_O, "velocity_O"), limits_of(values)};
  if (now_s) flown.now_ns = base::from_seconds(*now_s);
  py::gil_scoped_release release;
  return safe_part(config, *view, flown);
}

py::object first_meeting_of(const std::shared_ptr<OccupancyView>& view, const Trajectory& trajectory, double now_s,
                            double radius_m) {
  const auto meeting = place_of_meeting(*view, trajectory, base::from_seconds(now_s), radius_m);
  return meeting ? py::object(py::make_tuple(meeting->arc_m, meeting->after_s)) : py::object(py::none());
}

void bind_safe_part(py::module_& m) {
  py::class_<SafePart>(m, "SafePart", "The part of a trajectory that may be flown.")
      .def_property_readonly(
          "trajectory",
          [](const SafePart& part) { return part.trajectory ? py::cast(*part.trajectory) : py::object(py::none()); },
          "The trajectory, cut if needed to what can be flown and stopped in; None if there is no room to stop.")
      .def_readonly("problem", &SafePart::problem, "Where the corridor is not known to be free; '' if it is free.");
  m.def(
      "safe_part", &safe_part_of, py::arg("config"), py::arg("view").none(false), py::arg("trajectory"),
      py::arg("from_arc_m"), py::arg("radius_m"), py::arg("velocity_O"), py::arg("limits"),
      py::arg("now_s") = py::none(),
      "Checks the corridor of a trajectory from an arc length on, and cuts it to what can be flown and stopped in.\n\n"
      "limits: speed and acceleration, each horizontal, ascending, descending, in pairs; now_s: time at which the\n"
      "vehicle is at from_arc_m, None for that of the newest sweep. Releases the GIL.");
  m.def("first_meeting", &first_meeting_of, py::arg("view").none(false), py::arg("trajectory"), py::arg("now_s"),
        py::arg("radius_m"),
        "Returns where a ball that flies a trajectory from now on, and rests at its end, may touch something that "
        "moves:\n(arc length [m], seconds from now); None if it meets nothing.");
}

}  // namespace

void bind_planning_manager(py::module_& m) {
  bind_config<PlanningManagerConfig>(m, "PlanningManagerConfig",
                                     "Times, distances and timeouts of the planning manager.");
  bind_config<PlanningNodeConfig>(m, "PlanningNodeConfig",
                                  "Frames, rates, services and heartbeats of the planning_manager node.");
  bind_config<FencesConfig>(m, "FencesConfig", "Files of the fences of the planning_manager node, and their limits.");
  bind_config<HomeConfig>(m, "HomeConfig",
                          "The way home of the planning_manager node: which goals the battery allows.");
  bind_config<OtherUavsConfig>(m, "OtherUavsConfig", "Other UAVs of the planning_manager node.");
  bind_config<WorkTimeConfig>(m, "WorkTimeConfig",
                              "Simulated time of the planning_manager's work, where time waits for it.");
  bind_config<FlightSearchConfig>(m, "FlightSearchConfig",
                                  "Search of the planning manager: PathPlannerConfig with its defaults, and the field.")
      .def(
          "planner_config", [](const FlightSearchConfig& c) { return planning::PathPlannerConfig(c); },
          "Returns the values as a PathPlannerConfig.")
      .def("field_config", &FlightSearchConfig::field_config,
           "Returns the ClearanceFieldConfig of a field that keeps the distances which the search needs.");
  bind_words<HeadingMode>(m, "HeadingMode", "Which headings trajectories have.");
  bind_config<HeadingConfig>(m, "HeadingConfig", "Headings of the planning manager's trajectories.");
  bind_config<OctomapServerConfig>(m, "OctomapServerConfig", "The node that stands in for mrs_octomap_server.");
  bind_config<OctomapPlannerConfig>(m, "OctomapPlannerConfig", "The node that stands in for mrs_octomap_planner.");
  bind_config<BumperNodeConfig>(m, "BumperNodeConfig", "The bumper node beside its sectors.");
  bind_trajectory(m);
  m.def(
      "flight_time",
      [](const py::array& points, const LimitValues& limits, double deviation_m) {
        return planning::flight_time(points_of(points, "points"), limits_of(limits), deviation_m);
      },
      py::arg("points"), py::arg("limits"), py::arg("deviation_m"),
      "Time [s] from rest to rest along an (n, 3) float64 polyline, whose corners are rounded within deviation_m.\n\n"
      "limits: speed and acceleration, each horizontal, ascending, descending, in pairs.");
  bind_outcome(m);
  bind_safe_part(m);
  m.def(
      "run_plan_job", &plan_job, py::arg("planner"), py::arg("field"), py::arg("config"), py::arg("view"),
      py::arg("start_O"), py::arg("goal_O"), py::arg("limits"),
      "Brings the field up to date with the view, searches a path on it, and cuts that to known free space and to the\n"
      "longest flight time. The field must not be used by others meanwhile. Releases the GIL.\n\n"
      "planner: PathPlanner; field: ClearanceField with a FlightSearchConfig.field_config().");
  m.def("run_way_job", &way_job, py::arg("config"), py::arg("view").none(false), py::arg("start_O"), py::arg("goal_O"),
        py::arg("limits"), py::arg("way_O"),
        "Cuts a known way, (n, 3) float64 in O, as run_plan_job does, from its place that is nearest to the start on.\n"
        "It ends at the goal. Raises ValueError for a way without places. Releases the GIL.");
}

}  // namespace voxnav::bindings
