// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "floors.hpp"
#include "imu_samples.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"

namespace voxnav::bindings {
namespace {

using odometry::LidarOdometry;
using odometry::OdometryResult;
using odometry::Quality;

py::array_t<double> matrix_of(const odometry::Matrix6& matrix) {
  py::array_t<double> out({6, 6});
  Eigen::Map<Eigen::Matrix<double, 6, 6, Eigen::RowMajor>>(out.mutable_data()) = matrix;
  return out;
}

std::array<double, 3> list_of(const geometry::Vec3& v) { return {v.x(), v.y(), v.z()}; }

void add_imu(LidarOdometry& self, const py::array& stamps, const py::array& gyro, const py::array& accel) {
  for (const odometry::ImuSample& sample : imu_samples_of(stamps, gyro, accel)) self.add_imu(sample);
}

std::vector<geometry::Vec3f> points_of(const py::array& array) {
  const py::ssize_t columns = array.ndim() == 2 && array.shape(1) == 4 ? 4 : 3;
  const float* data = data_of<float>(array, "points_L", {-1, columns});
  std::vector<geometry::Vec3f> out(static_cast<std::size_t>(array.shape(0)));
  for (auto& point : out) {
    point = Eigen::Map<const geometry::Vec3f>(data);
    data += columns;
  }
  return out;
}

std::vector<float> times_of(const py::object& object, std::size_t num_points) {
  if (object.is_none()) return {};
  const auto array = py::array_t<float, py::array::c_style | py::array::forcecast>::ensure(object);
  if (!array || array.ndim() != 1 || static_cast<std::size_t>(array.shape(0)) != num_points) {
    PyErr_Clear();
    throw py::value_error("point_times must be one number per point");
  }
  return std::vector<float>(array.data(), array.data() + array.shape(0));
}

OdometryResult add_cloud(LidarOdometry& self, double stamp, const py::array& points_L, const py::object& point_times) {
  if (!std::isfinite(stamp)) throw py::value_error("stamp must be finite");
  const std::vector<geometry::Vec3f> points = points_of(points_L);
  const std::vector<float> times = times_of(point_times, points.size());
  py::gil_scoped_release release;
  return self.add_cloud(base::from_seconds(stamp), points, times);
}

py::dict counters_of(const LidarOdometry& self) {
  const odometry::OdometryCounters& c = self.counters();
  py::dict out;
  out["clouds"] = c.clouds;
  out["clouds_refused"] = c.clouds_refused;
  out["coasted"] = c.coasted;
  out["map_restarts"] = c.map_restarts;
  out["clock_jumps"] = c.clock_jumps;
  out["points_refused"] = c.points_refused;
  out["imu_samples"] = c.imu_samples;
  out["imu_refused"] = c.imu_refused;
  out["imu_clock_jumps"] = c.imu_clock_jumps;
  out["scans_without_imu"] = c.scans_without_imu;
  return out;
}

void bind_results(py::module_& m) {
  py::class_<Quality>(m, "OdometryQuality", "How far a pose of LidarOdometry may be trusted.")
      .def_property_readonly(
          "state", [](const Quality& q) { return to_member(q.state); }, "OdometryState.")
      .def_property_readonly(
          "reason_kind", [](const Quality& q) { return to_member(q.reason_kind); }, "OdometryReason.")
      .def_readonly("reason", &Quality::reason, "Why the odometry does not track, or in which directions it predicts.")
      .def_readonly("inlier_ratio", &Quality::inlier_ratio)
      .def_readonly("residual_m", &Quality::residual_m, "RMS of inlier residuals.")
      .def_readonly("iterations", &Quality::iterations)
      .def_readonly("num_points", &Quality::num_points)
      .def_readonly("eigenvalues", &Quality::eigenvalues,
                    "Share of the information per direction: translation, then rotation, smallest first.")
      .def_readonly("is_degenerate", &Quality::is_degenerate);
  py::class_<OdometryResult>(m, "OdometryResult", "Pose and quality after one cloud.")
      .def_property_readonly(
          "pose", [](const OdometryResult& r) { return pose_array(r.T_O_B); },
          "(4, 4) float64 T_O_B at the cloud's stamp (T_O_L unless T_B_L was given).")
      .def_property_readonly(
          "covariance", [](const OdometryResult& r) { return matrix_of(r.covariance); },
          "(6, 6) float64: translation [m^2], rotation [rad^2], axes of O.")
      .def_property_readonly("stamp", [](const OdometryResult& r) { return base::to_seconds(r.stamp_ns); })
      .def_property_readonly(
          "velocity_B", [](const OdometryResult& r) { return list_of(r.velocity_B); }, "m/s.")
      .def_property_readonly(
          "angular_velocity_B", [](const OdometryResult& r) { return list_of(r.angular_velocity_B); }, "rad/s.")
      .def_readonly("is_new", &OdometryResult::is_new, "False if the cloud was refused.")
      .def_readonly("quality", &OdometryResult::quality);
}

/// Seconds, or integers, which are nanoseconds.
std::vector<base::StampNs> stamps_of(const py::array& stamps) {
  std::vector<base::StampNs> out;
  if (py::isinstance<py::array_t<std::int64_t>>(stamps)) {
    const std::int64_t* t = data_of<std::int64_t>(stamps, "stamps", {-1});
    out.assign(t, t + stamps.shape(0));
    return out;
  }
  const double* t = data_of<double>(stamps, "stamps", {-1});
  for (py::ssize_t i = 0; i < stamps.shape(0); ++i) {
    if (!std::isfinite(t[i])) throw py::value_error("stamps must be finite");
    out.push_back(base::from_seconds(t[i]));
  }
  return out;
}

}  // namespace

std::vector<odometry::ImuSample> imu_samples_of(const py::array& stamps, const py::array& gyro,
                                                const py::array& accel) {
  const std::vector<base::StampNs> stamps_ns = stamps_of(stamps);
  const double* w = data_of<double>(gyro, "gyro", {-1, 3});
  const double* a = data_of<double>(accel, "accel", {-1, 3});
  const py::ssize_t size = stamps.shape(0);
  if (gyro.shape(0) != size || accel.shape(0) != size) throw py::value_error("stamps, gyro and accel differ in length");
  std::vector<odometry::ImuSample> out;
  for (py::ssize_t i = 0; i < size; ++i) {
    out.push_back({stamps_ns[static_cast<std::size_t>(i)], Eigen::Map<const geometry::Vec3>(w + 3 * i),
                   Eigen::Map<const geometry::Vec3>(a + 3 * i)});
  }
  return out;
}

void bind_odometry(py::module_& m) {
  bind_words<odometry::OdometryState>(m, "OdometryState", "How a pose of LidarOdometry came about.");
  bind_words<odometry::OdometryReason>(m, "OdometryReason", "Why an odometry is in the state it is in.");
  bind_results(m);
  bind_words<odometry::RegistrationMethod>(m, "RegistrationMethod", "What LidarOdometry registers a scan to.");
  bind_config<odometry::LidarOdometryConfig>(m, "LidarOdometryConfig", "Parameters of LidarOdometry.");
  py::class_<LidarOdometry>(m, "LidarOdometry", "LiDAR-inertial odometry against a bounded local map. Not thread-safe.")
      .def(py::init([](const odometry::LidarOdometryConfig& config, const py::object& T_B_L) {
             return LidarOdometry(config, T_B_L.is_none() ? geometry::Pose::Identity() : pose_of(T_B_L, "T_B_L"));
           }),
           py::arg("config") = odometry::LidarOdometryConfig(), py::arg("T_B_L") = py::none(),
           "T_B_L: (4, 4) float64, LiDAR in the body; identity when not given, poses are then those of the LiDAR.")
      .def("add_imu", &add_imu, py::arg("stamps"), py::arg("gyro"), py::arg("accel"),
           "stamps (n,) float64 [s], or int64 [ns]; gyro (n, 3) float64 [rad/s]; accel (n, 3) float64 [m/s^2], +9.81 "
           "up at rest;\n"
           "axes of B. Samples that are not finite or not newer are counted and dropped.")
      .def("add_cloud", &add_cloud, py::arg("stamp"), py::arg("points_L"), py::arg("point_times") = py::none(),
           "Registers one scan.\n\n"
           "stamp: start of the sweep [s]; points_L: (n, 3) or (n, 4) float32, frame L, not deskewed;\n"
           "point_times: (n,) seconds after the stamp. Returns OdometryResult; never raises for poor data.")
      .def(
          "reset", [](LidarOdometry& self) { self.reset(); },
          "Forgets map, motion and IMU samples, and starts again at the identity.")
      .def_property_readonly("counters", &counters_of)
      .def_property_readonly("num_map_points", &LidarOdometry::num_map_points)
      .def_property_readonly("memory_bytes", &LidarOdometry::memory_bytes);
}

}  // namespace voxnav::bindings
