// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/planning_manager.hpp"

#include <memory>

#include "bind_config.hpp"
#include "grid_update_args.hpp"
#include "planning_manager.hpp"
#include "point_lists.hpp"
#include "views.hpp"
#include "voxnav/pipeline/flight_search_config.hpp"
#include "voxnav/pipeline/navigation_map.hpp"
#include "voxnav/pipeline/planning_node_config.hpp"

namespace voxnav::bindings {
namespace {

using namespace pipeline;  // NOLINT: this file binds that namespace
using planning::OccupancyView;
using planning::Trajectory;

std::shared_ptr<OccupancyView> mutable_view(const NavigationMap& map) {
  // pybind11 holders are not const; nothing bound here changes a view.
  return std::const_pointer_cast<OccupancyView>(map.view());
}

template <NavigationMap::Applied (NavigationMap::*kApply)(const containers::GridUpdate&, std::uint32_t, double)>
std::string apply(NavigationMap& map, std::uint32_t sequence, double resolution_m, const py::object& block_indices,
                  const py::buffer& states, const py::object& removed, bool is_snapshot) {
  const containers::GridUpdate update = grid_update_from(block_indices, states, removed, is_snapshot);
  NavigationMap::Applied applied;
  {
    py::gil_scoped_release release;
    applied = (map.*kApply)(update, sequence, resolution_m);
  }
  if (applied == NavigationMap::Applied::kNeedsSnapshot) return "needs_snapshot";
  return applied == NavigationMap::Applied::kApplied ? "applied" : "ignored";
}

void bind_navigation_map(py::module_& m) {
  bind_config<NavigationMapConfig>(m, "NavigationMapConfig", "Limits and vehicle footprint of a NavigationMap.");
  const char* apply_doc =
      "Apply a GridUpdate message. Returns 'applied', 'ignored' (older than what is here) or 'needs_snapshot'.\n\n"
      "block_indices, removed: (n, 3) or flat integers; states: bytes, 1024 per block. Raises ValueError.";
  py::class_<NavigationMap>(m, "NavigationMap",
                            "What the planner flies by, frame O: local map, obstacles of the global map, altitude "
                            "limits, vehicle. Thread-safe.")
      .def(py::init<NavigationMapConfig>(), py::arg("config") = NavigationMapConfig{})
      .def("apply_local", &apply<&NavigationMap::apply_local>, py::arg("sequence"), py::arg("resolution_m"),
           py::arg("block_indices"), py::arg("states"), py::arg("removed"), py::arg("is_snapshot"), apply_doc)
      .def("apply_obstacles", &apply<&NavigationMap::apply_obstacles>, py::arg("sequence"), py::arg("resolution_m"),
           py::arg("block_indices"), py::arg("states"), py::arg("removed"), py::arg("is_snapshot"), apply_doc)
      .def(
          "set_T_W_O", [](NavigationMap& map, const py::array& T) { map.set_T_W_O(pose_of(T, "T_W_O")); },
          py::arg("T_W_O"))
      .def(
          "set_vehicle", [](NavigationMap& map, const py::object& p) { map.set_vehicle(vec3_of(p, "position_O")); },
          py::arg("position_O"))
      .def("clear_local", &NavigationMap::clear_local)
      .def("clear_obstacles", &NavigationMap::clear_obstacles)
      .def("view", &mutable_view, "Snapshot in frame O as an OccupancyView; None until everything is known.");
}

const char* name_of(ActionKind kind) {
  switch (kind) {
    case ActionKind::kPlan:
      return "plan";
    case ActionKind::kGenerate:
      return "generate";
    case ActionKind::kPublish:
      return "publish";
    case ActionKind::kHover:
      return "hover";
  }
  return "hover";
}

template <class T>
py::object optional_of(const std::optional<T>& value) {
  return value ? py::cast(*value) : py::object(py::none());
}

void bind_action(py::module_& m) {
  py::class_<Trajectory>(m, "Trajectory", "Positions at equal time steps; at rest at the last one.")
      .def(py::init([](const py::array& points, double dt_s) { return Trajectory(points_of(points, "points"), dt_s); }),
           py::arg("points"), py::arg("dt_s"))
      .def_property_readonly("points", [](const Trajectory& t) { return points_array(t.points()); })
      .def_property_readonly("dt_s", &Trajectory::dt_s)
      .def_property_readonly("length_m", &Trajectory::length_m)
      .def_property_readonly("duration_s", &Trajectory::duration_s);
  py::class_<Action>(m, "PlanningAction", "What the planning manager wants done: plan, generate, publish or hover.")
      .def_property_readonly("kind", [](const Action& a) { return name_of(a.kind); })
      .def_readonly("job", &Action::job)
      .def_readonly("reason", &Action::reason)
      .def_property_readonly("start_O", [](const Action& a) { return vec3_array(a.start_O); })
      .def_property_readonly("goal_O", [](const Action& a) { return vec3_array(a.goal_O); })
      .def_property_readonly("start_stamp_s", [](const Action& a) { return optional_of(a.start_stamp_s); })
      .def_property_readonly("waypoints_O", [](const Action& a) { return points_array(a.waypoints_O); })
      .def_property_readonly("heading_rad", [](const Action& a) { return optional_of(a.heading_rad); })
      .def_readonly("trajectory", &Action::trajectory);
  py::class_<PlanOutcome>(m, "PlanOutcome", "A search and what may be flown of its path.")
      .def_readonly("plan", &PlanOutcome::plan)
      .def_property_readonly("waypoints_O", [](const PlanOutcome& o) { return points_array(o.waypoints_O); })
      .def_readonly("is_to_goal", &PlanOutcome::is_to_goal)
      .def_readonly("left_m", &PlanOutcome::left_m)
      .def_readonly("problem", &PlanOutcome::problem);
}

py::dict status_of(const PlanningManager& manager) {
  const PlanningStatus& s = manager.status();
  py::dict out;
  out["state"] = static_cast<int>(s.state);
  out["reason"] = s.reason;
  out["goal_W"] = s.goal_W ? py::object(vec3_array(*s.goal_W)) : py::object(py::none());
  out["is_goal_reached"] = s.is_goal_reached;
  out["plan_status"] = s.plan_status;
  out["expansions"] = s.expansions;
  out["plan_s"] = s.plan_s;
  out["num_plans"] = s.num_plans;
  out["num_trajectories"] = s.num_trajectories;
  out["num_shortened"] = s.num_shortened;
  out["num_hovers"] = s.num_hovers;
  return out;
}

std::optional<double> optional_number(const py::object& value) {
  return value.is_none() ? std::nullopt : std::optional<double>(py::cast<double>(value));
}

void bind_inputs(py::class_<PlanningManager>& cls) {
  cls.def(
         "set_vehicle",
         [](PlanningManager& m, double stamp_s, const py::object& position_O, const py::object& velocity_O) {
           m.inputs().vehicle = {stamp_s, {vec3_of(position_O, "position_O"), vec3_of(velocity_O, "velocity_O")}};
         },
         py::arg("stamp_s"), py::arg("position_O"), py::arg("velocity_O"))
      .def(
          "set_prediction",
          [](PlanningManager& m, double stamp_s, std::vector<double> times_s, const py::array& positions_O) {
            m.inputs().prediction = {stamp_s, {std::move(times_s), points_of(positions_O, "positions_O")}};
          },
          py::arg("stamp_s"), py::arg("times_s"), py::arg("positions_O"))
      .def(
          "set_control",
          [](PlanningManager& m, double stamp_s, bool is_flying, bool accepts_goals, bool is_tracking) {
            m.inputs().control = {stamp_s, {is_flying, accepts_goals, is_tracking}};
          },
          py::arg("stamp_s"), py::arg("is_flying"), py::arg("accepts_goals"), py::arg("is_tracking") = false)
      .def(
          "set_frames",
          [](PlanningManager& m, const std::string& map, const std::string& control) {
            m.inputs().map_frame = map;
            m.inputs().control_frame = control;
          },
          py::arg("map"), py::arg("control"), "Names of the frames that map and odometry are in; '' where unknown.")
      .def(
          "set_limits",
          [](PlanningManager& m, double stamp_s, const std::array<double, 6>& v) {
            m.inputs().limits = {stamp_s, {v[0], v[1], v[2], v[3], v[4], v[5]}};
          },
          py::arg("stamp_s"), py::arg("values"),
          "values: speed and acceleration, each horizontal, ascending, descending, in pairs.")
      .def(
          "set_T_W_O",
          [](PlanningManager& m, double stamp_s, const py::array& T) {
            m.inputs().T_W_O = {stamp_s, pose_of(T, "T_W_O")};
          },
          py::arg("stamp_s"), py::arg("T_W_O"))
      .def(
          "set_map_stamp", [](PlanningManager& m, double stamp_s) { m.inputs().map_stamp_s = stamp_s; },
          py::arg("stamp_s"))
      .def(
          "set_lost_nodes",
          [](PlanningManager& m, const std::vector<std::string>& names) {
            m.inputs().lost_nodes = {names.begin(), names.end()};
          },
          py::arg("names"));
}

void bind_manager(py::module_& m) {
  bind_config<PlanningManagerConfig>(m, "PlanningManagerConfig",
                                     "Times, distances and timeouts of the planning manager.");
  py::class_<PlanningManager> cls(
      m, "PlanningManager",
      "State machine Idle (0), Planning (1), Moving (2); every call that may want something "
      "done returns a list of PlanningAction. Not thread-safe. Times are float seconds.");
  cls.def(py::init<PlanningManagerConfig, double, double>(), py::arg("config"), py::arg("min_altitude_m"),
          py::arg("max_altitude_m"))
      .def(
          "set_goal",
          [](PlanningManager& self, const py::object& goal_W, const py::object& heading_rad, double now_s) {
            return self.set_goal(vec3_of(goal_W, "goal_W"), optional_number(heading_rad), now_s);
          },
          py::arg("goal_W"), py::arg("heading_rad"), py::arg("now_s"), "Why the goal is refused; '' when it is taken.")
      .def("stop", &PlanningManager::stop, py::arg("reason"), py::arg("now_s"))
      .def("frame_jumped", &PlanningManager::frame_jumped, py::arg("reason"), py::arg("now_s"))
      .def("tick", &PlanningManager::tick, py::arg("now_s"))
      .def(
          "check",
          [](PlanningManager& self, const std::shared_ptr<OccupancyView>& view, double now_s) {
            return self.check(view.get(), now_s);
          },
          py::arg("view"), py::arg("now_s"))
      .def("plan_done", &PlanningManager::plan_done, py::arg("job"), py::arg("outcome"), py::arg("now_s"))
      .def(
          "generate_done",
          [](PlanningManager& self, std::uint64_t job, const std::string& problem, const Trajectory* trajectory,
             const std::shared_ptr<OccupancyView>& view, double now_s) {
            return self.generate_done(job, problem, trajectory ? *trajectory : Trajectory(), view.get(), now_s);
          },
          py::arg("job"), py::arg("problem"), py::arg("trajectory"), py::arg("view"), py::arg("now_s"))
      .def("publish_done", &PlanningManager::publish_done, py::arg("job"), py::arg("problem"), py::arg("now_s"))
      .def("hover_done", &PlanningManager::hover_done, py::arg("problem"), py::arg("now_s"))
      .def(
          "remaining_path",
          [](const PlanningManager& self, double now_s) { return points_array(self.remaining_path(now_s)); },
          py::arg("now_s"))
      .def_property_readonly("status", &status_of, "Dict with the fields of PlannerStatus.");
  bind_inputs(cls);
}

PlanOutcome plan_job(const planning::AStarPlanner& planner, const PlanningManagerConfig& config, const py::object& map,
                     const py::object& start_O, const py::object& goal_O, const std::array<double, 6>& v) {
  const auto view = view_of(map, planner.config().safety_distance_m);
  const geometry::Vec3 start = vec3_of(start_O, "start_O");
  const geometry::Vec3 goal = vec3_of(goal_O, "goal_O");
  const planning::DynamicsLimits limits{v[0], v[1], v[2], v[3], v[4], v[5]};
  if (!limits.is_valid()) throw py::value_error("limits must be six positive numbers");
  py::gil_scoped_release release;
  return run_plan_job(planner, config, *view, start, goal, limits);
}

}  // namespace

void bind_planning_manager(py::module_& m) {
  bind_config<PlanningNodeConfig>(m, "PlanningNodeConfig",
                                  "Frames, rates, services and heartbeats of the planning_manager node.");
  bind_config<FlightSearchConfig>(m, "FlightSearchConfig", "AStarConfig with the defaults of the planning manager.")
      .def(
          "search_config", [](const FlightSearchConfig& c) { return planning::AStarConfig(c); },
          "The same as an AStarConfig.");
  bind_navigation_map(m);
  bind_action(m);
  bind_manager(m);
  m.def("run_plan_job", &plan_job, py::arg("planner"), py::arg("config"), py::arg("view"), py::arg("start_O"),
        py::arg("goal_O"), py::arg("limits"),
        "Search a way and cut it to known free space and the longest flight time; releases the GIL.");
}

}  // namespace voxnav::bindings
