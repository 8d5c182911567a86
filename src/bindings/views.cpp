// SPDX-License-Identifier: BSD-3-Clause
#include "views.hpp"

#include "voxnav/planning/state_grid_view.hpp"

namespace voxnav::bindings {
namespace py = pybind11;
namespace {

using containers::StateGrid;

/// The view holds the Python object, so a grid made on the fly lives as long as its view.
std::shared_ptr<const planning::OccupancyView> view_of_grid(const py::object& grid, double grown_by_m) {
  const auto* raw = py::cast<const StateGrid*>(grid);
  const std::shared_ptr<const StateGrid> shared(raw, [grid](const StateGrid*) {});
  return std::make_shared<planning::StateGridView>(shared, grown_by_m);
}

}  // namespace

std::shared_ptr<const planning::OccupancyView> view_of(const py::object& map, double safety_distance_m) {
  if (py::isinstance<planning::OccupancyView>(map)) return py::cast<std::shared_ptr<planning::OccupancyView>>(map);
  if (py::isinstance<StateGrid>(map)) return view_of_grid(map, 0.0);
  if (py::hasattr(map, "occupancy_view")) {
    return py::cast<std::shared_ptr<planning::OccupancyView>>(map.attr("occupancy_view")());
  }
  if (py::hasattr(map, "obstacles")) {
    const py::object grid = map.attr("obstacles")(safety_distance_m);
    if (py::isinstance<StateGrid>(grid)) return view_of_grid(grid, safety_distance_m);
  }
  throw py::value_error("view must be an OccupancyView, a StateGrid, a LocalMap or a SubmapCollection, got " +
                        py::cast<std::string>(py::str(map.get_type())));
}

}  // namespace voxnav::bindings
