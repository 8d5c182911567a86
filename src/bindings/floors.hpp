// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "pybind.hpp"

namespace voxnav::bindings {

/// One function, and one file of that name, per floor of the core; called lowest first.
void bind_base(pybind11::module_& m);
void bind_geometry(pybind11::module_& m);
void bind_containers(pybind11::module_& m);
void bind_cloud(pybind11::module_& m);
void bind_occupancy(pybind11::module_& m);
void bind_submap(pybind11::module_& m);
void bind_odometry(pybind11::module_& m);
void bind_graph(pybind11::module_& m);
void bind_planning(pybind11::module_& m);
void bind_pipeline(pybind11::module_& m);

}  // namespace voxnav::bindings
