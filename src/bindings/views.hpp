// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "pybind.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::bindings {

/// The view behind a Python object: an OccupancyView, a StateGrid, a LocalMap (copied), or anything with a method
/// `obstacle_grid(safety_distance_m)`, such as a SubmapCollection. A StateGrid must not change while its view is used.
/// @throws py::value_error (ValueError) naming what was given instead
std::shared_ptr<const planning::OccupancyView> view_of(const pybind11::object& map, double safety_distance_m);

}  // namespace voxnav::bindings
