// SPDX-License-Identifier: BSD-3-Clause
#include <memory>

#include "arrays.hpp"
#include "floors.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::bindings {
namespace {

using planning::OccupancyView;

py::array_t<std::int8_t> states_at(const OccupancyView& view, const py::array& points) {
  const float* data = data_of<float>(points, "points", {-1, 3});
  const py::ssize_t n = points.shape(0);
  py::array_t<std::int8_t> out(n);
  for (py::ssize_t i = 0; i < n; ++i) {
    const geometry::Vec3 p(data[3 * i], data[3 * i + 1], data[3 * i + 2]);
    const bool near = ((p.array().abs() / view.resolution_m()) < 1073741824.0).all();
    const auto state = near ? view.state(geometry::index_of(p, view.resolution_m())) : containers::State::kUnknown;
    out.mutable_data()[i] = static_cast<std::int8_t>(state);
  }
  return out;
}

}  // namespace

void bind_planning(py::module_& m) {
  py::class_<OccupancyView, std::shared_ptr<OccupancyView>>(m, "OccupancyView",
                                                            "What a planner sees of a map; abstract.")
      .def_property_readonly("resolution_m", &OccupancyView::resolution_m)
      .def("states", &states_at, py::arg("points"),
           "(n,) int8 states (0 unknown, 1 free, 2 occupied) of (n, 3) float32 points in the view's frame [m].");
}

}  // namespace voxnav::bindings
