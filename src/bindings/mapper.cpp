// SPDX-License-Identifier: BSD-3-Clause
#include "mapper.hpp"

#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "imu_samples.hpp"
#include "voxnav/pipeline/mapper.hpp"

namespace voxnav::bindings {
namespace {

using pipeline::Mapper;
using pipeline::MapperConfig;
using pipeline::MapperStep;
using pipeline::SweepFate;
using pipeline::SweepPoses;

/// Takes the configuration of one part out of the keyword arguments.
template <class Part, class Member>
void take_part(const char* name, py::dict* values, Member* member) {
  if (!values->contains(name)) return;
  const py::object value = (*values)[name];
  if (!py::isinstance<Part>(value)) throw py::type_error(std::string(name) + " must be a configuration object");
  *member = value.cast<Part>();
  PyDict_DelItemString(values->ptr(), name);
}

MapperConfig config_of(const py::kwargs& kwargs) {
  py::dict values;
  for (const auto& item : kwargs) values[item.first] = item.second;
  MapperConfig parts;
  take_part<occupancy::LocalMapConfig>("map", &values, &parts.map);
  take_part<occupancy::MovingThingsConfig>("moving", &values, &parts.moving);
  take_part<pipeline::SubmapSchedulerConfig>("submap", &values, &parts.submap);
  take_part<pipeline::LoadControlConfig>("load", &values, &parts.load);
  take_part<odometry::LidarOdometryConfig>("odometry", &values, &parts.odometry);
  const std::vector<std::string> problems = base::assign(&parts, to_values(values));
  if (!problems.empty()) throw base::ConfigError(problems);
  return parts;
}

void bind_mapper_config(py::module_& m) {
  bind_config<pipeline::SensorConfig>(m, "SensorConfig", "What Mapper has to know of one sensor beside its mount.");
  auto cls = bind_config<MapperConfig>(m, "MapperConfig", "Parameters of Mapper.");
  cls.def(
      py::init(&config_of),
      "Defaults, with fields set by keyword; map, moving, submap, load and odometry are configurations of their own.\n"
      "If odometry is given, the mapper estimates its poses itself, by LiDAR odometry.\n\nRaises ConfigError.");
  cls.def_readwrite("map", &MapperConfig::map)
      .def_readwrite("moving", &MapperConfig::moving)
      .def_readwrite("submap", &MapperConfig::submap)
      .def_readwrite("load", &MapperConfig::load)
      .def_readwrite("sensors", &MapperConfig::sensors, "List of SensorConfig, by Sweep.sensor; at least one.")
      .def_readwrite("odometry", &MapperConfig::odometry, "LidarOdometryConfig, or None: poses come from elsewhere.")
      .def_readwrite("first_submap_id", &MapperConfig::first_submap_id,
                     "Id of the first submap; None takes the seconds of its first stamp.");
}

/// Reads the pose for a whole sweep, which is then not deskewed.
SweepPoses poses_of(const py::object& T_O_B, const geometry::Pose& T_B_L) {
  const geometry::Pose body = pose_of(py::cast<py::array>(T_O_B), "T_O_B");
  const geometry::Pose sensor = body * T_B_L;
  return {{sensor, sensor, 0}, body};
}

/// A mapper with the poses of its sensors on the body.
struct MountedMapper {
  MountedMapper(const MapperConfig& config, const geometry::Pose& T_B_L)
      : mounts(config.sensors.size()), mapper(config, T_B_L) {
    mounts.front() = T_B_L;
  }
  std::vector<std::optional<geometry::Pose>> mounts;
  Mapper mapper;
};

void set_mount(MountedMapper& self, std::size_t sensor, const py::array& T_B_L) {
  const geometry::Pose mount = pose_of(T_B_L, "T_B_L");
  self.mapper.set_mount(sensor, mount);
  self.mounts[sensor] = mount;
}

void queue_sweep(MountedMapper& self, const cloud::Sweep& sweep, const py::object& T_O_B) {
  std::optional<SweepPoses> poses;
  if (!T_O_B.is_none()) {
    if (sweep.sensor >= self.mounts.size() || !self.mounts[sweep.sensor])
      throw py::value_error("the mount of sensor " + std::to_string(sweep.sensor) + " is unknown");
    poses = poses_of(T_O_B, *self.mounts[sweep.sensor]);
  }
  self.mapper.add_sweep(sweep, poses);
}

std::vector<pipeline::Handover> add_sweep(MountedMapper& self, const cloud::Sweep& sweep, const py::object& T_O_B) {
  queue_sweep(self, sweep, T_O_B);
  std::vector<pipeline::Handover> out;
  while (self.mapper.has_next()) {
    for (auto& handover : self.mapper.next().handovers) out.push_back(std::move(handover));
    for (auto& handover : self.mapper.close_due()) out.push_back(std::move(handover));
  }
  return out;
}

void add_imu(MountedMapper& self, const py::array& stamps, const py::array& gyro, const py::array& accel) {
  for (const odometry::ImuSample& sample : imu_samples_of(stamps, gyro, accel)) self.mapper.add_imu(sample);
}

void bind_step(py::module_& m) {
  bind_words<SweepFate>(m, "SweepFate", "Whether a sweep was mapped, or why it was dropped.");
  py::class_<MapperStep>(m, "MapperStep", "The result of Mapper.next() for one sweep.")
      .def_property_readonly(
          "fate", [](const MapperStep& s) { return to_member(s.fate); },
          "SweepFate: MAPPED; NO_POSE: no pose came, or none can come any more; CROWDED: too many sweeps waited;\n"
          "LATE: newer sweeps were mapped already; SURPLUS: it came sooner than the sensor's max_rate_hz allows.")
      .def_readonly("sensor", &MapperStep::sensor, "Number of the sensor of the sweep.")
      .def_readonly("leads", &MapperStep::leads,
                    "True if the sweep was mapped and is of the first sensor that delivers, whose sweeps set the pace.")
      .def_readonly("reason", &MapperStep::reason, "A sentence, unless the sweep was mapped.")
      .def_readonly("map_cleared", &MapperStep::map_cleared, "Why the map was cleared before, or None.")
      .def_property_readonly(
          "stamp", [](const MapperStep& s) { return base::to_seconds(s.stamp_ns); }, "Stamp of the sweep [s].")
      .def_property_readonly(
          "T_O_B", [](const MapperStep& s) { return pose_array(s.T_O_B); },
          "(4, 4) float64 pose halfway through the sweep, if the sweep was mapped.")
      .def_readonly("handovers", &MapperStep::handovers,
                    "List of the Handover of submaps that were closed because the map had to be cleared.");
}

}  // namespace

void bind_mapper(py::module_& m) {
  bind_mapper_config(m);
  bind_step(m);
  py::class_<MountedMapper>(m, "Mapper",
                            "The mapping pipeline: filtered sweeps go in, the local map and handovers come out. The\n"
                            "local mapper node wraps the same class. Frames: O origin of the poses, B body, L LiDAR. "
                            "Not thread-safe.")
      .def(py::init([](const MapperConfig& config, const py::object& T_B_L) {
             const auto mount = T_B_L.is_none() ? geometry::Pose::Identity() : pose_of(T_B_L, "T_B_L");
             return std::make_unique<MountedMapper>(config, mount);
           }),
           py::arg("config") = MapperConfig{}, py::arg("T_B_L") = py::none(),
           "T_B_L: (4, 4) float64, first sensor on the body; None is the identity. Raises ConfigError.")
      .def("set_mount", &set_mount, py::arg("sensor"), py::arg("T_B_L"),
           "Sets the (4, 4) float64 pose on the body of a sensor, without which its sweeps are dropped.\n\n"
           "Raises ValueError if the configuration has no such sensor.")
      .def(
          "expect_imu", [](MountedMapper& self) { self.mapper.expect_imu(); },
          "There will be IMU samples: sweeps wait, up to 80 of them, until these have shown where up is.")
      .def_property_readonly(
          "odometry_problems", [](const MountedMapper& self) { return self.mapper.odometry_problems(); },
          "What is wrong with the samples and the frame of the mapper's own odometry: list of sentences for people.")
      .def("add_imu", &add_imu, py::arg("stamps"), py::arg("gyro"), py::arg("accel"),
           "Adds IMU samples as LidarOdometry.add_imu() does; they are used only if MapperConfig.odometry is set.")
      .def(
          "add_pose",
          [](MountedMapper& self, base::StampNs stamp_ns, const py::array& T_O_B) {
            return self.mapper.add_pose(stamp_ns, pose_of(T_O_B, "T_O_B"));
          },
          py::arg("stamp_ns"), py::arg("T_O_B"),
          "Adds a pose of the body; the poses of sweeps are interpolated. Returns False if the pose is too late and "
          "refused.")
      .def("add_sweep", &add_sweep, py::arg("sweep"), py::arg("T_O_B") = py::none(),
           "Adds a sweep, and maps it and the sweeps before it as soon as their poses are known.\n\n"
           "T_O_B: (4, 4) float64, one pose for the whole sweep; None: from add_pose() or the mapper's odometry.\n"
           "Returns the list of Handover that are due, oldest first.")
      .def("queue_sweep", &queue_sweep, py::arg("sweep"), py::arg("T_O_B") = py::none(),
           "Adds a sweep without mapping it. Then call next() while has_next(), and close_due() after each next().")
      .def_property_readonly(
          "is_waiting_for_imu", [](const MountedMapper& self) { return self.mapper.is_waiting_for_imu(); },
          "True if a sweep waits for IMU samples before its pose is estimated.")
      .def("has_next", [](MountedMapper& self) { return self.mapper.has_next(); })
      .def(
          "next", [](MountedMapper& self) { return self.mapper.next(); },
          "Maps the oldest sweep, or drops it with a reason. Returns a MapperStep.")
      .def(
          "close_due", [](MountedMapper& self) { return self.mapper.close_due(); },
          "Returns the list of Handover that are due after the sweep that next() mapped.")
      .def(
          "end_input", [](MountedMapper& self) { self.mapper.end_input(); },
          "Ends the input: next() drops the sweeps that still wait for poses.")
      .def(
          "finish", [](MountedMapper& self, const std::string& reason) { return self.mapper.finish(reason); },
          py::arg("reason") = "shutdown", "Closes the open submap. Returns a list of at most one Handover.")
      .def_property_readonly(
          "map", [](MountedMapper& self) -> occupancy::LocalMap& { return self.mapper.map(); },
          py::return_value_policy::reference_internal, "The LocalMap.")
      .def_property_readonly(
          "moving_things", [](const MountedMapper& self) { return self.mapper.moving().things(); },
          "What moves in the map, as of the newest sweep: list of MovingThing.");
}

}  // namespace voxnav::bindings
