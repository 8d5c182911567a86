// SPDX-License-Identifier: BSD-3-Clause
#include "arrays.hpp"
#include "floors.hpp"
#include "voxnav/containers/state_grid.hpp"

namespace voxnav::bindings {
namespace {

using containers::State;
using containers::StateGrid;

StateGrid grid_from_array(const py::array& states, const py::object& origin, double resolution_m) {
  if (states.ndim() != 3) throw py::value_error("states must be a (nx, ny, nz) array of int8");
  const auto* data = data_of<std::int8_t>(states, "states", {-1, -1, -1});
  const geometry::Vec3 corner = vec3_of(origin, "origin");
  StateGrid grid(resolution_m);
  const geometry::Index3 first =
      geometry::index_of(corner + geometry::Vec3::Constant(resolution_m * 0.5), resolution_m);
  const int nx = static_cast<int>(states.shape(0));
  const int ny = static_cast<int>(states.shape(1));
  const int nz = static_cast<int>(states.shape(2));
  for (int x = 0; x < nx; ++x) {
    for (int y = 0; y < ny; ++y) {
      for (int z = 0; z < nz; ++z) {
        const std::int8_t value = data[(static_cast<std::size_t>(x) * ny + y) * nz + z];
        if (value < 0 || value > 2)
          throw py::value_error("states holds a value other than 0 unknown, 1 free, 2 occupied");
        if (value != 0) grid.set(first + geometry::Index3{x, y, z}, static_cast<State>(value));
      }
    }
  }
  return grid;
}

py::array_t<std::int8_t> states_at(const StateGrid& grid, const py::array& points) {
  const float* data = data_of<float>(points, "points", {-1, 3});
  const py::ssize_t n = points.shape(0);
  py::array_t<std::int8_t> out(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const geometry::Vec3 p(data[3 * i], data[3 * i + 1], data[3 * i + 2]);
    out.mutable_data()[i] = static_cast<std::int8_t>(grid.state(p));
  }
  return out;
}

}  // namespace

void bind_containers(py::module_& m) {
  py::class_<StateGrid>(m, "StateGrid", "Three-state voxel grid in blocks of 16^3; what is absent is unknown.")
      .def(py::init<double>(), py::arg("resolution_m"))
      .def_static("from_array", &grid_from_array, py::arg("states"), py::arg("origin"), py::arg("resolution_m"),
                  "Grid from a dense (nx, ny, nz) int8 array (0 unknown, 1 free, 2 occupied).\n\n"
                  "origin: (3,) metres, lowest corner of voxel [0, 0, 0]; snapped to the grid.")
      .def("states", &states_at, py::arg("points"), "(n,) int8 states of (n, 3) float32 points [m].")
      .def_property_readonly("resolution_m", &StateGrid::resolution_m)
      .def_property_readonly("memory_bytes", &StateGrid::memory_bytes);
}

}  // namespace voxnav::bindings
