// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string>

#include "arrays.hpp"

namespace voxnav::bindings {

/// A Python UserWarning; an exception where the caller turned warnings into errors.
inline void warn(const std::string& text) {
  if (PyErr_WarnEx(PyExc_UserWarning, text.c_str(), 1) != 0) throw py::error_already_set();
}

/// (x, y, z) in metres or None, with a warning, since whoever opens the file must know of it.
inline py::object said_shift(const std::optional<geometry::Vec3>& shift_m, const std::string& path) {
  if (!shift_m) return py::none();
  py::tuple out = py::make_tuple(shift_m->x(), shift_m->y(), shift_m->z());
  warn(path + ": the map lies beyond the reach of an OctoMap and was shifted; add " +
       py::cast<std::string>(py::str(py::object(out))) + " m to coordinates in the file to get those of the map");
  return out;
}

}  // namespace voxnav::bindings
