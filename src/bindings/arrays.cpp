// SPDX-License-Identifier: BSD-3-Clause
#include "arrays.hpp"

namespace voxnav::bindings {

geometry::Pose pose_of(const py::array& array, const char* name) {
  const double* data = data_of<double>(array, name, {4, 4});
  geometry::Pose pose;
  pose.matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data);
  if (!geometry::is_valid(pose) ||
      (pose.matrix().row(3) - Eigen::RowVector4d(0, 0, 0, 1)).cwiseAbs().maxCoeff() > 1e-9) {
    throw py::value_error(std::string(name) +
                          " must be a finite rigid transform (orthonormal rotation, last row 0 0 0 1)");
  }
  return pose;
}

geometry::Bend bend_of(const py::object& T) {
  geometry::Bend out;
  if (T.is_none()) return out;
  const double* data = data_of<double>(T.cast<py::array>(), "bend", {2, 4, 4});
  using Rows = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>;
  out.T_S_begin.matrix() = Rows(data);
  out.T_S_end.matrix() = Rows(data + 16);
  return out;
}

py::array_t<double> pose_array(const geometry::Pose& pose) {
  py::array_t<double> out({4, 4});
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(out.mutable_data()) = pose.matrix();
  return out;
}

geometry::Vec3 vec3_of(const py::object& object, const char* name) {
  const auto array = py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(object);
  if (!array) {
    PyErr_Clear();
    throw py::value_error(std::string(name) + " must be three numbers");
  }
  if (array.size() != 3 || array.ndim() != 1) throw py::value_error(std::string(name) + " must be three numbers");
  return {array.data()[0], array.data()[1], array.data()[2]};
}

}  // namespace voxnav::bindings
