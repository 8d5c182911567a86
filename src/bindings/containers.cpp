// SPDX-License-Identifier: BSD-3-Clause
#include "arrays.hpp"
#include "floors.hpp"
#include "grid_update_args.hpp"
#include "voxnav/containers/state_grid.hpp"

namespace voxnav::bindings {
namespace {

using containers::StateGrid;
using containers::VoxelState;

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
        if (value != 0) grid.set(first + geometry::Index3{x, y, z}, static_cast<VoxelState>(value));
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

void apply_update(StateGrid& grid, const py::object& block_indices, const py::buffer& states, const py::object& removed,
                  bool is_snapshot) {
  const containers::GridUpdate update = grid_update_from(block_indices, states, removed, is_snapshot);
  py::gil_scoped_release release;
  containers::apply(update, &grid);
}

py::dict update_dict(containers::GridUpdate&& update) {
  py::dict out;
  out["is_snapshot"] = update.is_snapshot;
  out["block_indices"] = array_from(std::move(update.block_indices), 3);
  out["states"] = py::bytes(reinterpret_cast<const char*>(update.states.data()), update.states.size());
  out["removed"] = array_from(std::move(update.removed_block_indices), 3);
  return out;
}

py::array_t<float> centers(const StateGrid& grid, int state) {
  if (state < 1 || state > 2) throw py::value_error("state must be 1 free or 2 occupied");
  std::vector<float> out;
  for (const geometry::Index3& index : grid.sorted_block_indices()) {
    const containers::StateBlock* block = grid.find_block(index);
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      if (block->get(offset) != static_cast<VoxelState>(state)) continue;
      const geometry::Vec3 p = geometry::center_of(geometry::voxel_at(index, offset), grid.resolution_m());
      for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(p[axis]));
    }
  }
  return array_from(std::move(out), 3);
}

}  // namespace

void bind_containers(py::module_& m) {
  py::class_<StateGrid>(m, "StateGrid", "Three-state voxel grid in blocks of 16^3; what is absent is unknown.")
      .def(py::init<double>(), py::arg("resolution_m"))
      .def_static("from_array", &grid_from_array, py::arg("states"), py::arg("origin"), py::arg("resolution_m"),
                  "Makes a grid from a dense (nx, ny, nz) int8 array (0 unknown, 1 free, 2 occupied).\n\n"
                  "origin: (3,) metres, lowest corner of voxel [0, 0, 0]; snapped to the grid.")
      .def("states", &states_at, py::arg("points"), "(n,) int8 states of (n, 3) float32 points [m].")
      .def("apply_update", &apply_update, py::arg("block_indices"), py::arg("states"), py::arg("removed"),
           py::arg("is_snapshot"),
           "Applies a GridUpdate message.\n\n"
           "block_indices, removed: (n, 3) or flat integers, x y z per block of 16^3 voxels; states: bytes or uint8,\n"
           "1024 per block. Raises ValueError on lengths that do not match; the grid is then unchanged.")
      .def(
          "snapshot", [](const StateGrid& grid) { return update_dict(containers::snapshot_of(grid)); },
          "The whole grid as a dict with the keywords of apply_update().")
      .def("centers", &centers, py::arg("state"),
           "(k, 3) float32 centres [m] of the voxels in a state (1 free, 2 occupied), in block order.")
      .def_property_readonly("num_blocks", [](const StateGrid& grid) { return grid.blocks().size(); })
      .def_property_readonly("resolution_m", &StateGrid::resolution_m)
      .def_property_readonly("memory_bytes", &StateGrid::memory_bytes);
}

}  // namespace voxnav::bindings
