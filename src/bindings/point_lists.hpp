// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "arrays.hpp"

namespace voxnav::bindings {

/// (n, 3) float64 to points.
inline std::vector<geometry::Vec3> points_of(const py::array& array, const char* name) {
  const double* data = data_of<double>(array, name, {-1, 3});
  std::vector<geometry::Vec3> out;
  out.reserve(static_cast<std::size_t>(array.shape(0)));
  for (py::ssize_t i = 0; i < array.shape(0); ++i) out.emplace_back(data[3 * i], data[3 * i + 1], data[3 * i + 2]);
  return out;
}

/// Points to (n, 3) float64.
inline py::array_t<double> points_array(const std::vector<geometry::Vec3>& points) {
  py::array_t<double> out({static_cast<py::ssize_t>(points.size()), py::ssize_t{3}});
  double* data = out.mutable_data();
  for (const geometry::Vec3& p : points) data = std::copy(p.data(), p.data() + 3, data);
  return out;
}

inline py::array_t<double> vec3_array(const geometry::Vec3& p) {
  py::array_t<double> out(3);
  std::copy(p.data(), p.data() + 3, out.mutable_data());
  return out;
}

}  // namespace voxnav::bindings
