// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <array>
#include <cmath>
#include <limits>
#include <memory>

#include "arrays.hpp"
#include "floors.hpp"
#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::bindings {
namespace {

using geometry::DistanceField;

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

geometry::Vec3 row_of(const float* points, py::ssize_t row) {
  return {points[3 * row], points[3 * row + 1], points[3 * row + 2]};
}

py::array_t<double> distance(const DistanceField& field, const py::array& points_S) {
  const float* points = data_of<float>(points_S, "points_S", {-1, 3});
  const py::ssize_t size = points_S.shape(0);
  std::vector<double> out(static_cast<std::size_t>(size), kNaN);
  {
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < size; ++i) {
      const geometry::Vec3 p_S = row_of(points, i);
      if (p_S.allFinite()) field.sample(p_S, &out[static_cast<std::size_t>(i)], nullptr);
    }
  }
  return array_from(std::move(out), 0);
}

py::array_t<double> gradient(const DistanceField& field, const py::array& points_S) {
  const float* points = data_of<float>(points_S, "points_S", {-1, 3});
  const py::ssize_t size = points_S.shape(0);
  std::vector<double> out(static_cast<std::size_t>(3 * size), kNaN);
  {
    py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < size; ++i) {
      const geometry::Vec3 p_S = row_of(points, i);
      double distance_m = 0.0;
      geometry::Vec3 slope;
      if (!p_S.allFinite() || !field.sample(p_S, &distance_m, &slope)) continue;
      for (int k = 0; k < 3; ++k) out[static_cast<std::size_t>(3 * i + k)] = slope[k];
    }
  }
  return array_from(std::move(out), 3);
}

/// Three columns of every surface point, picked by `member`.
py::array_t<float> surface_rows(const DistanceField& field, geometry::Vec3f geometry::SurfacePoint::*member) {
  std::vector<float> out;
  out.reserve(3 * field.surface_points().size());
  for (const geometry::SurfacePoint& point : field.surface_points()) {
    for (int k = 0; k < 3; ++k) out.push_back((point.*member)[k]);
  }
  return array_from(std::move(out), 3);
}

py::array_t<float> bent_surface_points(const DistanceField& field, const py::object& T) {
  const geometry::Bend bend = bend_of(T);
  std::vector<float> out;
  for (const geometry::SurfacePoint& point : field.surface_points()) {
    const geometry::Vec3 p_S = bend.at(static_cast<double>(point.phase)) * point.position.cast<double>();
    for (int k = 0; k < 3; ++k) out.push_back(static_cast<float>(p_S[k]));
  }
  return array_from(std::move(out), 3);
}

py::array_t<float> surface_weights(const DistanceField& field) {
  std::vector<float> out;
  out.reserve(field.surface_points().size());
  for (const geometry::SurfacePoint& point : field.surface_points()) out.push_back(point.weight);
  return array_from(std::move(out), 0);
}

py::tuple quaternion_of(const py::array& T_A_B) {
  const Eigen::Quaterniond q(pose_of(T_A_B, "T_A_B").linear());
  return py::make_tuple(q.x(), q.y(), q.z(), q.w());
}

py::array_t<double> pose_from_quaternion(const py::object& position, const std::array<double, 4>& q_xyzw) {
  const Eigen::Quaterniond q(q_xyzw[3], q_xyzw[0], q_xyzw[1], q_xyzw[2]);
  const auto pose = geometry::make_pose(vec3_of(position, "position"), q);
  if (!pose) throw py::value_error("a pose must be finite, and the norm of its quaternion 1 within 5 %");
  return pose_array(*pose);
}

void bind_poses(py::module_& m) {
  using geometry::Pose;
  m.def(
      "yaw_of", [](const py::array& T) { return geometry::yaw_of(pose_of(T, "T_A_B")); }, py::arg("T_A_B"),
      "Heading of a (4, 4) float64 pose [rad].");
  m.def("wrap_angle", &geometry::wrap_angle, py::arg("angle_rad"), "Returns the equivalent angle in [-pi, pi).");
  m.def(
      "gravity_aligned", [](const py::array& T) { return pose_array(geometry::gravity_aligned(pose_of(T, "T_A_B"))); },
      py::arg("T_A_B"), "(4, 4) with the position and heading of a pose, roll and pitch 0.");
  m.def(
      "pose_from_yaw",
      [](const py::object& position, double yaw_rad) {
        return pose_array(geometry::from_position_yaw(vec3_of(position, "position"), yaw_rad));
      },
      py::arg("position"), py::arg("yaw_rad"), "(4, 4) gravity-aligned pose at a position (3,) [m].");
  m.def(
      "interpolate_pose",
      [](const py::array& a, const py::array& b, double ratio) {
        return pose_array(geometry::interpolate(pose_of(a, "a"), pose_of(b, "b"), ratio));
      },
      py::arg("a"), py::arg("b"), py::arg("ratio"),
      "(4, 4): linear in position, slerp in rotation; ratio 0 gives a, 1 gives b.");
  m.def("pose_from_quaternion", &pose_from_quaternion, py::arg("position"), py::arg("q_xyzw"),
        "(4, 4) of a position (3,) and a quaternion (4,), as the nodes read them from messages. Raises ValueError.");
  m.def(
      "as_sent", [](const py::array& T) { return pose_array(geometry::as_sent(pose_of(T, "T_A_B"))); },
      py::arg("T_A_B"), "(4, 4): a pose as it arrives when it is sent as position and quaternion.");
  m.def("quaternion_of", &quaternion_of, py::arg("T_A_B"),
        "(x, y, z, w) of a (4, 4) pose, as the nodes write it to messages.");
}

}  // namespace

void bind_geometry(py::module_& m) {
  bind_poses(m);
  py::class_<DistanceField, std::shared_ptr<DistanceField>>(
      m, "DistanceField",
      "Signed distances around the surfaces of one submap, frame S. Objects are immutable and of a subclass.")
      .def("distance", &distance, py::arg("points_S"),
           "Signed distance (negative inside) at (n, 3) float32 points.\n\n"
           "Returns (n,) float64 metres, NaN where unobserved or the point is not finite.")
      .def("gradient", &gradient, py::arg("points_S"),
           "Gradient of the distance at (n, 3) float32 points.\n\nReturns (n, 3) float64, NaN where unobserved.")
      .def(
          "surface_points", [](const DistanceField& f) { return surface_rows(f, &geometry::SurfacePoint::position); },
          "(n, 3) float32 points on the observed surfaces, frame S, metres.")
      .def(
          "surface_normals", [](const DistanceField& f) { return surface_rows(f, &geometry::SurfacePoint::normal); },
          "(n, 3) float32 unit normals of surface_points(), towards free space.")
      .def(
          "bent_surface_points", &bent_surface_points, py::arg("bend"),
          "(n, 3) float32 surface_points() where a bend, (2, 4, 4) float64 of submap_bends(), moves them: each by the\n"
          "share of it that goes with the time at which the point was seen.")
      .def("surface_weights", &surface_weights, "(n,) float32 confidences of surface_points(), above 0.")
      .def_property_readonly("resolution_m", &DistanceField::resolution_m, "Edge of one voxel, metres.");
}

}  // namespace voxnav::bindings
