// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/fences.hpp"

#include <pybind11/stl.h>

#include <memory>

#include "arrays.hpp"
#include "bind_words.hpp"
#include "fences.hpp"

namespace voxnav::bindings {
namespace {

using namespace planning;  // NOLINT: this file binds that namespace

Prism prism_of(const py::array& outline, double min_z, double max_z) {
  const double* data = data_of<double>(outline, "outline", {-1, 2});
  Prism out;
  out.min_z = min_z;
  out.max_z = max_z;
  for (py::ssize_t i = 0; i < outline.shape(0); ++i) out.outline.emplace_back(data[2 * i], data[2 * i + 1]);
  return out;
}

py::array_t<double> outline_of(const Prism& prism) {
  py::array_t<double> out({static_cast<py::ssize_t>(prism.outline.size()), py::ssize_t{2}});
  double* data = out.mutable_data();
  for (const auto& corner : prism.outline) data = std::copy(corner.data(), corner.data() + 2, data);
  return out;
}

std::shared_ptr<Fences> make_fences(const std::optional<Prism>& area, const std::vector<Prism>& zones) {
  return std::make_shared<Fences>(area, zones);
}

}  // namespace

void bind_fences(py::module_& m) {
  bind_words<FenceKind>(m, "FenceKind", "What a fence is: the AREA that may not be left, or a ZONE not to be entered.");
  py::class_<Prism>(m, "Prism", "An upright prism: a polygon in the plane, from min_z to max_z [m].")
      .def(py::init(&prism_of), py::arg("outline"), py::arg("min_z"), py::arg("max_z"),
           "outline: (n, 2) float64 corners in order, either way round, the first one not repeated.")
      .def_property_readonly("outline", &outline_of, "(n, 2) float64.")
      .def_readonly("min_z", &Prism::min_z)
      .def_readonly("max_z", &Prism::max_z)
      .def_property_readonly("problem", &problem_of, "Why the prism cannot be used, '' if it can.");
  py::class_<FenceContact>(m, "FenceContact", "The fence that a place violates.")
      .def_property_readonly(
          "kind", [](const FenceContact& contact) { return to_member(contact.kind); }, "A FenceKind.")
      .def_readonly("zone", &FenceContact::zone, "Number of the zone; 0 for the area.");
  py::class_<FenceTouch>(m, "FenceTouch", "Where a segment first violates a fence.")
      .def_readonly("t", &FenceTouch::t, "Parameter on the segment from 0 to 1.")
      .def_readonly("contact", &FenceTouch::contact);
  py::class_<Fences, std::shared_ptr<Fences>>(
      m, "Fences",
      "The fences of a flight in one frame: an area that bounds where the vehicle's centre may be, and zones, which a\n"
      "ball of its size may not touch. Immutable.")
      .def(py::init(&make_fences), py::arg("area") = py::none(), py::arg("zones") = std::vector<Prism>{},
           "area: Prism or None; zones: list of Prism. Raises ValueError naming the prism that cannot be used.")
      .def_property_readonly("area", &Fences::area)
      .def_property_readonly("zones", &Fences::zones)
      .def(
          "contact",
          [](const Fences& fences, const py::object& point, double radius_m) {
            return fences.contact(vec3_of(point, "point"), radius_m);
          },
          py::arg("point"), py::arg("radius_m") = 0.0,
          "The FenceContact of a place that is outside the area or within radius_m of a zone; None if it is neither.")
      .def(
          "first_touch",
          [](const Fences& fences, const py::object& from, const py::object& to, double radius_m) {
            return fences.first_touch(vec3_of(from, "from_point"), vec3_of(to, "to_point"), radius_m);
          },
          py::arg("from_point"), py::arg("to_point"), py::arg("radius_m") = 0.0,
          "The FenceTouch at which a segment first leaves the area or comes within radius_m of a zone; None if it does "
          "not.");
}

}  // namespace voxnav::bindings
