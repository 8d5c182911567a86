// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <memory>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "fences.hpp"
#include "floors.hpp"
#include "point_lists.hpp"
#include "views.hpp"
#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/clearance_field.hpp"
#include "voxnav/planning/corridor.hpp"
#include "voxnav/planning/obstacle_sectors.hpp"
#include "voxnav/planning/path_planner.hpp"

namespace voxnav::bindings {
namespace {

using namespace planning;  // NOLINT: this file binds that namespace

py::array_t<std::int8_t> states_at(const OccupancyView& view, const py::array& points) {
  const float* data = data_of<float>(points, "points", {-1, 3});
  const py::ssize_t n = points.shape(0);
  py::array_t<std::int8_t> out(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const geometry::Vec3 p(data[3 * i], data[3 * i + 1], data[3 * i + 2]);
    const bool is_near = ((p.array().abs() / view.resolution_m()) < 1073741824.0).all();
    const VoxelState state = is_near ? view.state(geometry::index_of(p, view.resolution_m())) : VoxelState::kUnknown;
    out.mutable_data()[i] = static_cast<std::int8_t>(state);
  }
  return out;
}

PlanResult plan(const AStarPlanner& planner, const py::object& map, const py::object& start, const py::object& goal) {
  const auto view = view_of(map, planner.config().safety_distance_m);
  const geometry::Vec3 start_point = vec3_of(start, "start");
  const geometry::Vec3 goal_point = vec3_of(goal, "goal");
  py::gil_scoped_release release;
  return planner.plan(*view, start_point, goal_point);
}

CorridorResult corridor(const py::object& map, const py::array& points, double radius_m, bool allow_unknown) {
  const auto view = view_of(map, 0.0);
  const std::vector<geometry::Vec3> line = points_of(points, "points");
  const CorridorRule rule = allow_unknown ? CorridorRule::kNotOccupied : CorridorRule::kKnownFreeOnly;
  py::gil_scoped_release release;
  return check_corridor(*view, line, radius_m, rule);
}

py::tuple sectors(const ObstacleSectorsConfig& config, const py::object& map, const py::object& position,
                  double heading_rad) {
  const auto view = view_of(map, 0.0);
  const geometry::Vec3 at = vec3_of(position, "position");
  std::vector<ObstacleSector> found;
  {
    py::gil_scoped_release release;
    found = obstacle_sectors(config, *view, at, heading_rad);
  }
  const auto count = static_cast<py::ssize_t>(found.size());
  py::array_t<bool> is_known(count);
  py::array_t<double> distance_m(count);
  for (py::ssize_t i = 0; i < count; ++i) {
    is_known.mutable_data()[i] = found[i].is_known;
    distance_m.mutable_data()[i] = found[i].has_obstacle ? found[i].distance_m : std::nan("");
  }
  return py::make_tuple(is_known, distance_m);
}

ClearanceUpdate update_field(ClearanceField& field, const py::object& map) {
  const auto view = view_of(map, field.config().safety_distance_m);
  py::gil_scoped_release release;
  return field.update(*view);
}

/// Calls fn(point) for each row of an (n, 3) float32 array.
template <class T, class Fn>
py::array_t<T> for_each_point(const py::array& points, Fn fn) {
  const float* data = data_of<float>(points, "points", {-1, 3});
  py::array_t<T> out(points.shape(0));
  T* to = out.mutable_data();
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    to[i] = fn(geometry::Vec3(data[3 * i], data[3 * i + 1], data[3 * i + 2]));
  }
  return out;
}

void bind_clearance_field(py::module_& m) {
  bind_config<ClearanceFieldConfig>(m, "ClearanceFieldConfig", "Distances that a clearance field keeps.");
  py::class_<ClearanceUpdate>(m, "ClearanceUpdate", "What one update of a clearance field did.")
      .def_readonly("changed_blocks", &ClearanceUpdate::changed_blocks)
      .def_readonly("recomputed_blocks", &ClearanceUpdate::recomputed_blocks);
  py::class_<ClearanceField>(m, "ClearanceField",
                             "Distances to obstacles, and the connected parts of flyable space, kept up to date.")
      .def(py::init<ClearanceFieldConfig>(), py::arg("config") = ClearanceFieldConfig{})
      .def("update", &update_field, py::arg("view"),
           "Takes over a map; only what changed blocks can reach is computed again.\n\n"
           "view: OccupancyView, StateGrid, LocalMap or SubmapCollection. Raises ValueError if safety_distance_m is "
           "more than\n"
           "16 voxels of the view, or if the map needs more than max_memory_mib; the field is empty in that case.")
      .def(
          "clearance",
          [](const ClearanceField& field, const py::array& points) {
            return for_each_point<double>(points, [&](const geometry::Vec3& p) { return field.clearance(p); });
          },
          py::arg("points_W"),
          "(n,) float64 exact distances [m] of (n, 3) float32 points to the nearest occupied voxel, radius_m if none\n"
          "is nearer, NaN for points that are not finite.")
      .def(
          "components",
          [](const ClearanceField& field, const py::array& points) {
            return for_each_point<std::uint32_t>(points, [&](const geometry::Vec3& p) { return field.component(p); });
          },
          py::arg("points_W"),
          "(n,) uint32 numbers of the connected parts of flyable space that hold (n, 3) float32 points, 0 = none.\n"
          "Numbers hold until the next update.")
      .def_property_readonly("config", &ClearanceField::config)
      .def_property_readonly("resolution_m", &ClearanceField::resolution_m,
                             "Edge of a voxel [m], 0 before the first update.")
      .def_property_readonly("num_blocks", &ClearanceField::num_blocks)
      .def_property_readonly("memory_bytes", &ClearanceField::memory_bytes);
}

AnyAnglePlan plan_any_angle(const PathPlanner& planner, const ClearanceField& field, const py::object& start,
                            const py::object& goal) {
  const geometry::Vec3 start_point = vec3_of(start, "start");
  const geometry::Vec3 goal_point = vec3_of(goal, "goal");
  py::gil_scoped_release release;
  return planner.plan(field, start_point, goal_point);
}

void bind_path_planner(py::module_& m) {
  bind_config<PathPlannerConfig>(m, "PathPlannerConfig", "Costs and limits of a path.");
  py::class_<AnyAnglePlan, PlanResult>(m, "AnyAnglePlan", "A path of straight segments in any direction.")
      .def_readonly("length_m", &AnyAnglePlan::length_m)
      .def_readonly("cost_m", &AnyAnglePlan::cost_m, "Length weighted by the costs of what the path flies through.")
      .def_readonly("lower_bound_m", &AnyAnglePlan::lower_bound_m,
                    "No path over the lattice of cells costs less; infinite where there is no way.");
  py::class_<PathPlanner>(m, "PathPlanner", "Any-angle planner on a clearance field, with exact clearance.")
      .def(py::init<PathPlannerConfig>(), py::arg("config") = PathPlannerConfig{})
      .def("plan", &plan_any_angle, py::arg("field"), py::arg("start_W"), py::arg("goal_W"),
           "Searches a short path between two points (three numbers each, field's frame [m]).\n\n"
           "Returns an AnyAnglePlan, whose path is (k, 3) float64; never raises for a start or goal that cannot be\n"
           "used. Raises ValueError if the field's radius_m is less than the distances that have costs.");
}

void bind_plan_status(py::module_& m) {
  bind_words<PlanStatus>(m, "PlanStatus", "Why a search ended as it did.");
  m.def(
      "explain", [](const std::string& status) { return explain(from_word<PlanStatus>(status, "status")); },
      py::arg("status"), "Explains a PlanStatus in one sentence for people.");
}

void bind_plan_result(py::module_& m) {
  py::class_<PlanResult>(m, "PlanResult", "The path that a search found, and why it ended.")
      .def_property_readonly(
          "status", [](const PlanResult& r) { return to_member(r.status); },
          "PlanStatus; only COMPLETE reaches the requested goal.")
      .def_property_readonly("reason", [](const PlanResult& r) { return explain(r.status); })
      .def_property_readonly(
          "path", [](const PlanResult& r) { return points_array(r.path); },
          "(k, 3) float64 voxel centres from start to end, view's frame [m]; (0, 3) without a path.")
      .def_readonly("partial", &PlanResult::is_partial, "True if there is a path, but not to the requested goal.")
      .def_readonly("cost_m", &PlanResult::cost_m, "Length weighted by the cost of the cells, before simplifying.")
      .def_readonly("remaining_m", &PlanResult::remaining_m, "Straight distance from the path's end to the goal.")
      .def_readonly("expansions", &PlanResult::expansions)
      .def_readonly("seconds", &PlanResult::seconds)
      .def_readonly("memory_bytes", &PlanResult::memory_bytes);
}

void bind_obstacle_sectors(py::module_& m) {
  bind_config<ObstacleSectorsConfig>(m, "ObstacleSectorsConfig", "How the space around a vehicle is divided.");
  m.def(
      "obstacle_sectors", &sectors, py::arg("config"), py::arg("view"), py::arg("position"), py::arg("heading_rad"),
      "Returns (is_known, distance_m), (n + 2,) bool and float64, of the n sectors around a vehicle, counter-clockwise "
      "from\nahead, then below and above. distance_m [m] is that to the nearest occupied voxel, NaN without one.\n\n"
      "Raises ValueError unless position and heading are finite.");
}

void bind_corridor(py::module_& m) {
  py::class_<CorridorResult>(m, "CorridorResult", "Outcome of a corridor check.")
      .def_readonly("safe", &CorridorResult::is_safe)
      .def_property_readonly(
          "first_unsafe_m",
          [](const CorridorResult& r) -> py::object {
            return r.is_safe ? py::object(py::none()) : py::cast(r.first_unsafe_m);
          },
          "Arc length at which the corridor first touches an unsafe voxel [m], or None.")
      .def_property_readonly("unsafe_state", [](const CorridorResult& r) { return static_cast<int>(r.unsafe_state); })
      .def_property_readonly("unsafe_point", [](const CorridorResult& r) { return vec3_array(r.unsafe_point); })
      .def_readonly("fence", &CorridorResult::fence, "The FenceContact if a fence is what is unsafe, or None.")
      .def_property_readonly("what_is_unsafe", &what_is_unsafe, "What is unsafe, in a few words for people.")
      .def_readonly("length_m", &CorridorResult::length_m);
  m.def("check_corridor", &corridor, py::arg("view"), py::arg("points"), py::arg("radius_m"),
        py::arg("allow_unknown") = false,
        "Checks the space that a ball sweeps along an (n, 3) float64 polyline. Only known free space within the fences "
        "of\n"
        "the view is safe; with allow_unknown, whatever is neither occupied nor in a zone.");
}

}  // namespace

void bind_planning(py::module_& m) {
  py::class_<OccupancyView, std::shared_ptr<OccupancyView>>(m, "OccupancyView",
                                                            "The interface through which planning reads a map.")
      .def_property_readonly("resolution_m", &OccupancyView::resolution_m)
      .def("states", &states_at, py::arg("points"),
           "(n,) int8 states (0 unknown, 1 free, 2 occupied) of (n, 3) float32 points in the view's frame [m].");
  bind_plan_status(m);
  bind_words<UnknownPolicy>(m, "UnknownPolicy", "How a search treats unknown cells.");
  bind_plan_result(m);
  bind_fences(m);
  bind_corridor(m);
  bind_obstacle_sectors(m);
  bind_clearance_field(m);
  bind_config<AStarConfig>(m, "AStarConfig", "Costs and limits of a search.");
  py::class_<AStarPlanner>(m, "AStarPlanner",
                           "Bounded A* on voxels: 26 neighbours, no corner cutting, octile heuristic.")
      .def(py::init<AStarConfig>(), py::arg("config") = AStarConfig{})
      .def("plan", &plan, py::arg("view"), py::arg("start_W"), py::arg("goal_W"),
           "Searches the cheapest path between two points (three numbers each, view's frame [m]).\n\n"
           "view: OccupancyView, StateGrid, LocalMap or SubmapCollection; must not change during the call.\n"
           "Returns a PlanResult; never raises for a start or goal that cannot be used.");
  bind_path_planner(m);
}

}  // namespace voxnav::bindings
