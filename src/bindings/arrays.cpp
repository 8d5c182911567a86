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

std::vector<geometry::Pose> poses_of(const py::array& array, const char* name) {
  const double* data = data_of<double>(array, name, {-1, 4, 4});
  std::vector<geometry::Pose> out(static_cast<std::size_t>(array.shape(0)));
  for (std::size_t i = 0; i < out.size(); ++i) {
    out[i].matrix() = Eigen::Map<const Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(data + 16 * i);
    if (!geometry::is_valid(out[i]))
      throw py::value_error(std::string(name) + ": row " + std::to_string(i) + " is no rigid transform");
  }
  return out;
}

std::vector<geometry::StampedPose> stamped_poses_of(const py::array& stamps_s, const py::array& poses,
                                                    const char* name) {
  const std::vector<geometry::Pose> rows = poses_of(poses, name);
  const double* stamps = data_of<double>(stamps_s, "stamps_s", {static_cast<py::ssize_t>(rows.size())});
  std::vector<geometry::StampedPose> out(rows.size());
  for (std::size_t i = 0; i < rows.size(); ++i) out[i] = {base::from_seconds(stamps[i]), rows[i]};
  return out;
}

py::array_t<double> pose_array(const geometry::Pose& pose) {
  py::array_t<double> out({4, 4});
  Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(out.mutable_data()) = pose.matrix();
  return out;
}

py::array_t<double> stamps_array(const std::vector<geometry::StampedPose>& poses) {
  std::vector<double> out;
  out.reserve(poses.size());
  for (const geometry::StampedPose& pose : poses) out.push_back(base::to_seconds(pose.stamp_ns));
  return array_from(std::move(out), 0);
}

py::array_t<double> poses_array(const std::vector<geometry::StampedPose>& poses) {
  const auto n = static_cast<py::ssize_t>(poses.size());
  py::array_t<double> out(std::vector<py::ssize_t>{n, 4, 4});
  for (py::ssize_t i = 0; i < n; ++i) {
    Eigen::Map<Eigen::Matrix<double, 4, 4, Eigen::RowMajor>>(out.mutable_data() + 16 * i) =
        poses[static_cast<std::size_t>(i)].pose.matrix();
  }
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
