// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>

#include <string>
#include <utility>
#include <vector>

#include "pybind.hpp"
#include "voxnav/geometry/pose.hpp"

/// Strict numpy arguments: a wrong dtype, shape or layout raises a ValueError that names the argument, what it is and
/// what it must be. Nothing is converted or copied silently.
namespace voxnav::bindings {

namespace py = pybind11;

/// Throws py::value_error unless `array` is C-contiguous with dtype T and the given shape (-1 = any length).
template <class T>
const T* data_of(const py::array& array, const char* name, const std::vector<py::ssize_t>& shape) {
  std::string expected;
  bool same_shape = static_cast<std::size_t>(array.ndim()) == shape.size();
  for (std::size_t i = 0; i < shape.size(); ++i) {
    expected += (i ? ", " : "") + (shape[i] < 0 ? std::string("n") : std::to_string(shape[i]));
    if (same_shape && shape[i] >= 0 && array.shape(static_cast<py::ssize_t>(i)) != shape[i]) same_shape = false;
  }
  const bool same_dtype = py::isinstance<py::array_t<T>>(array);
  const bool contiguous = (array.flags() & py::array::c_style) != 0;
  if (!same_shape || !same_dtype || !contiguous) {
    std::string got;
    for (py::ssize_t i = 0; i < array.ndim(); ++i) got += (i ? ", " : "") + std::to_string(array.shape(i));
    throw py::value_error(std::string(name) + " must be a C-contiguous (" + expected + ") array of " +
                          py::cast<std::string>(py::str(py::dtype::of<T>())) + ", got (" + got + ") of " +
                          py::cast<std::string>(py::str(py::object(array.dtype()))) +
                          (contiguous ? "" : ", not C-contiguous"));
  }
  return static_cast<const T*>(array.data());
}

/// 4x4 float64, a rigid transform.
geometry::Pose pose_of(const py::array& array, const char* name);
/// (n, 4, 4), rigid.
std::vector<geometry::Pose> poses_of(const py::array& array, const char* name);
/// (n,) seconds and (n, 4, 4).
std::vector<geometry::StampedPose> stamped_poses_of(const py::array& stamps_s, const py::array& poses,
                                                    const char* name);
py::array_t<double> pose_array(const geometry::Pose& pose);
/// (n,) seconds.
py::array_t<double> stamps_array(const std::vector<geometry::StampedPose>& poses);
/// (n, 4, 4).
py::array_t<double> poses_array(const std::vector<geometry::StampedPose>& poses);
/// (2, 4, 4); None is rigid.
geometry::Bend bend_of(const py::object& T);
/// (3,) of numbers.
geometry::Vec3 vec3_of(const py::object& object, const char* name);

/// Hands a vector's memory to numpy without a copy, C-contiguous in `shape`, whose product is the vector's size.
template <class T>
py::array_t<T> array_from(std::vector<T>&& values, const std::vector<py::ssize_t>& shape) {
  auto* owned = new std::vector<T>(std::move(values));
  py::capsule free_when_done(owned, [](void* p) { delete static_cast<std::vector<T>*>(p); });
  return py::array_t<T>(shape, owned->data(), free_when_done);
}

/// Hands over a vector as an array with rows of `columns` numbers; `columns` = 0 makes a flat array.
template <class T>
py::array_t<T> array_from(std::vector<T>&& values, py::ssize_t columns) {
  const auto size = static_cast<py::ssize_t>(values.size());
  if (columns == 0) return array_from(std::move(values), std::vector<py::ssize_t>{size});
  return array_from(std::move(values), std::vector<py::ssize_t>{size / columns, columns});
}

}  // namespace voxnav::bindings
