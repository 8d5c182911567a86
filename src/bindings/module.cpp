// SPDX-License-Identifier: BSD-3-Clause

#include "floors.hpp"
#include "pybind.hpp"
#include "voxnav/base/config.hpp"

PYBIND11_MODULE(_core, m) {
  namespace py = pybind11;
  m.doc() = "voxnav's ROS-free core. Frames, units and shapes: docs/architecture.md.";
  py::register_exception<voxnav::base::ConfigError>(m, "ConfigError", PyExc_ValueError);
  voxnav::bindings::bind_base(m);
  voxnav::bindings::bind_geometry(m);
  voxnav::bindings::bind_containers(m);
  voxnav::bindings::bind_cloud(m);
  voxnav::bindings::bind_occupancy(m);
  voxnav::bindings::bind_submap(m);
  voxnav::bindings::bind_odometry(m);
  voxnav::bindings::bind_graph(m);
  voxnav::bindings::bind_planning(m);
  voxnav::bindings::bind_pipeline(m);
}
