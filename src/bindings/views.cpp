// SPDX-License-Identifier: BSD-3-Clause
#include "views.hpp"

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::bindings {
namespace py = pybind11;
namespace {

using containers::StateGrid;

/// Keeps a reference to the Python object, so that a temporary grid lives as long as its view.
std::shared_ptr<const planning::OccupancyView> view_of_grid(const py::object& grid, double grown_by_m) {
  const auto* raw = py::cast<const StateGrid*>(grid);
  const std::shared_ptr<const StateGrid> shared(raw, [grid](const StateGrid*) {});
  return std::make_shared<planning::StateGridView>(shared, grown_by_m);
}

/// Copies the map: planning may read any block, and the map may change meanwhile.
std::shared_ptr<const planning::OccupancyView> view_of_local_map(const occupancy::LocalMap& map) {
  auto grid = std::make_shared<StateGrid>(map.config().resolution_m);
  containers::apply(map.snapshot(), grid.get());
  return std::make_shared<planning::StateGridView>(grid);
}

}  // namespace

std::shared_ptr<const planning::OccupancyView> view_of(const py::object& map, double safety_distance_m) {
  if (py::isinstance<planning::OccupancyView>(map)) return py::cast<std::shared_ptr<planning::OccupancyView>>(map);
  if (py::isinstance<StateGrid>(map)) return view_of_grid(map, 0.0);
  if (py::isinstance<occupancy::LocalMap>(map)) return view_of_local_map(py::cast<const occupancy::LocalMap&>(map));
  if (py::hasattr(map, "obstacle_grid"))
    return view_of_grid(map.attr("obstacle_grid")(safety_distance_m), safety_distance_m);
  throw py::value_error("view must be an OccupancyView, a StateGrid, a LocalMap or a SubmapCollection, got " +
                        py::cast<std::string>(py::str(map.get_type())));
}

}  // namespace voxnav::bindings
