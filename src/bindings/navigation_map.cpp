// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/pipeline/navigation_map.hpp"

#include <pybind11/stl.h>

#include <memory>
#include <string>
#include <utility>

#include "bind_config.hpp"
#include "grid_update_args.hpp"
#include "planning_manager.hpp"
#include "point_lists.hpp"
#include "voxnav/containers/moving_thing.hpp"

namespace voxnav::bindings {
namespace {

using namespace pipeline;  // NOLINT: this file binds that namespace
using planning::OccupancyView;

std::shared_ptr<OccupancyView> mutable_view(const NavigationMap& map) {
  // pybind11 holders are not const; nothing bound here changes a view.
  return std::const_pointer_cast<OccupancyView>(map.view());
}

template <NavigationMap::Applied (NavigationMap::*kApply)(const containers::GridUpdate&, std::uint32_t, double)>
py::object apply(NavigationMap& map, std::uint32_t sequence, double resolution_m, const py::object& block_indices,
                 const py::buffer& states, const py::object& removed, bool is_snapshot) {
  const containers::GridUpdate update = grid_update_from(block_indices, states, removed, is_snapshot);
  NavigationMap::Applied applied;
  {
    py::gil_scoped_release release;
    applied = (map.*kApply)(update, sequence, resolution_m);
  }
  return to_member(applied);
}

constexpr py::ssize_t kThingNumbers = 12;

/// Rows of id, position, velocity, half size, and the standard deviations of position and velocity.
std::vector<containers::MovingThing> things_of(const py::array& rows) {
  const double* row = data_of<double>(rows, "things", {-1, kThingNumbers});
  std::vector<containers::MovingThing> out;
  for (py::ssize_t i = 0; i < rows.shape(0); ++i, row += kThingNumbers) {
    const auto vec = [&](int first) { return geometry::Vec3(row[first], row[first + 1], row[first + 2]); };
    out.push_back({static_cast<std::uint32_t>(row[0]), vec(1), vec(4), vec(7), row[10], row[11]});
  }
  return out;
}

void set_sightings(NavigationMap& map, double stamp_s, double resolution_m, const py::array& hits,
                   const py::array& returns, const py::array& things) {
  const auto* voxel = data_of<std::int32_t>(hits, "hits", {-1, 3});
  const auto* num_returns = data_of<std::int32_t>(returns, "returns", {hits.shape(0)});
  SweepSightings out{base::from_seconds(stamp_s), resolution_m, {}, things_of(things)};
  for (py::ssize_t i = 0; i < hits.shape(0); ++i) {
    out.hits.push_back({{voxel[3 * i], voxel[3 * i + 1], voxel[3 * i + 2]}, num_returns[i]});
  }
  map.set_sightings(out);
}

containers::OtherUav other_uav(std::string name, double stamp_s, double step_s, const py::array& places,
                               double radius_m, double growth_mps, double late_growth_mps, double max_growth_m,
                               double horizon_s, double seen_s) {
  return {std::move(name), base::from_seconds(stamp_s),
          step_s,          points_of(places, "places"),
          radius_m,        growth_mps,
          late_growth_mps, max_growth_m,
          horizon_s,       base::from_seconds(seen_s)};
}

void bind_other_uav(py::module_& m) {
  py::class_<containers::OtherUav>(m, "OtherUav", "Another UAV, as it announced where it will be.")
      .def(py::init(&other_uav), py::arg("name"), py::arg("stamp_s"), py::arg("step_s"), py::arg("places"),
           py::arg("radius_m"), py::arg("growth_mps"), py::arg("late_growth_mps"), py::arg("max_growth_m"),
           py::arg("horizon_s"), py::arg("seen_s"),
           "places: (k, 3) float64, frame O, the first one at stamp_s, then one every step_s. It is inside a ball of\n"
           "radius_m around its place, which grows by growth_mps from stamp_s on, and by late_growth_mps in addition\n"
           "after the last place, but by no more than max_growth_m. It is kept clear of for horizon_s after seen_s.")
      .def_readonly("name", &containers::OtherUav::name)
      .def_readonly("radius_m", &containers::OtherUav::radius_m)
      .def_readonly("horizon_s", &containers::OtherUav::horizon_s);
}

}  // namespace

void bind_navigation_map(py::module_& m) {
  bind_other_uav(m);
  bind_config<NavigationMapConfig>(m, "NavigationMapConfig", "Limits and vehicle footprint of a NavigationMap.");
  bind_words<NavigationMap::Applied>(m, "Applied",
                                     "Whether a grid update was applied. NEEDS_SNAPSHOT: a message was missed;\n"
                                     "IGNORED: the update is older than the grid.");
  const char* apply_doc =
      "Applies a GridUpdate message. Returns Applied.\n\n"
      "block_indices, removed: (n, 3) or flat integers; states: bytes, 1024 per block. Raises ValueError.";
  py::class_<NavigationMap>(m, "NavigationMap",
                            "The map that the planner uses, frame O: local map, obstacles of the global map, altitude "
                            "limits and vehicle. Thread-safe.")
      .def(py::init<NavigationMapConfig>(), py::arg("config") = NavigationMapConfig{})
      .def("apply_local", &apply<&NavigationMap::apply_local>, py::arg("sequence"), py::arg("resolution_m"),
           py::arg("block_indices"), py::arg("states"), py::arg("removed"), py::arg("is_snapshot"), apply_doc)
      .def("apply_obstacles", &apply<&NavigationMap::apply_obstacles>, py::arg("sequence"), py::arg("resolution_m"),
           py::arg("block_indices"), py::arg("states"), py::arg("removed"), py::arg("is_snapshot"), apply_doc)
      .def("set_sightings", &set_sightings, py::arg("stamp_s"), py::arg("resolution_m"), py::arg("hits"),
           py::arg("returns"), py::arg("things"),
           "Sets what the newest sweep showed beside the local map. Raises ValueError.\n\n"
           "hits: (n, 3) int32 voxels, returns: (n,) int32 in each; things: (k, 12) float64, rows of id, position,\n"
           "velocity, half size, and standard deviations of position and velocity [m, m/s].")
      .def(
          "set_others", &NavigationMap::set_others, py::arg("others"),
          "Sets where other UAVs will be, a list of OtherUav; it counts from the next sightings on. Raises ValueError\n"
          "for one without places, or with numbers that are not finite or negative.")
      .def(
          "set_T_W_O", [](NavigationMap& map, const py::array& T) { map.set_T_W_O(pose_of(T, "T_W_O")); },
          py::arg("T_W_O"))
      .def(
          "set_vehicle", [](NavigationMap& map, const py::object& p) { map.set_vehicle(vec3_of(p, "position_O")); },
          py::arg("position_O"))
      .def(
          "set_fences",
          [](NavigationMap& map, const std::shared_ptr<planning::Fences>& fences) { map.set_fences(fences); },
          py::arg("fences_O").none(true), "Sets the fences of the flight, frame O; None for no fences.")
      .def("set_altitudes", &NavigationMap::set_altitudes, py::arg("min_m"), py::arg("max_m"),
           "Replaces the altitude limits of the configuration, for all later views. Raises ConfigError.")
      .def("clear_local", &NavigationMap::clear_local)
      .def("clear_obstacles", &NavigationMap::clear_obstacles)
      .def("view", &mutable_view, "Snapshot in frame O as an OccupancyView; None until everything is known.");
}

}  // namespace voxnav::bindings
