// SPDX-License-Identifier: BSD-3-Clause
#include "simulation_uav.hpp"

#include <memory>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "voxnav_simulation/scene.hpp"
#include "voxnav_simulation/trajectory_generator.hpp"
#include "voxnav_simulation/uav.hpp"

namespace voxnav::bindings {
namespace {

using namespace voxnav_simulation;  // NOLINT: this file binds that namespace

TrackerLimits limits_named(const std::string& word) {
  return limits_of(UavConstraintsConfig{}, from_word<ConstraintSet>(word, "constraints"));
}

std::unique_ptr<Uav> make_uav(const UavConfig& config, std::uint64_t seed, const GnssDriftConfig& drift,
                              const ImuConfig& imu, const std::string& constraints, const std::shared_ptr<Scene>& scene,
                              const UavFaults& faults) {
  const UavSetup setup{config, drift, imu, limits_named(constraints), faults};
  return std::make_unique<Uav>(setup, seed, scene ? sensed_world_of(scene) : SensedWorld{});
}

std::vector<HeadedPoint> headed_points(const py::array& array, const char* name) {
  const double* data = data_of<double>(array, name, {-1, 4});
  std::vector<HeadedPoint> out;
  for (py::ssize_t i = 0; i < array.shape(0); ++i, data += 4) out.push_back({{data[0], data[1], data[2]}, data[3]});
  return out;
}

py::array_t<double> point_rows(const std::vector<HeadedPoint>& points) {
  std::vector<double> out;
  for (const HeadedPoint& p : points)
    out.insert(out.end(), {p.position.x(), p.position.y(), p.position.z(), p.heading_rad});
  return array_from(std::move(out), 4);
}

void require(const CommandResult& result) {
  if (!result.success) throw py::value_error(result.message);
}

py::array_t<double> step(Uav& uav, double duration_s) {
  if (!(duration_s >= 0 && duration_s < 1e5)) throw py::value_error("duration_s must be between 0 and 1e5 seconds");
  std::vector<double> rows;
  {
    const py::gil_scoped_release release;
    for (auto i = std::llround(duration_s / kStep_s); i > 0; --i) {
      uav.step();
      const ImuReading& s = uav.imu();
      rows.insert(rows.end(), {base::to_seconds(s.stamp_ns), s.gyro.x(), s.gyro.y(), s.gyro.z(), s.accel.x(),
                               s.accel.y(), s.accel.z()});
    }
  }
  return array_from(std::move(rows), 7);
}

void set_trajectory(Uav& uav, const py::array& points, double dt_s, bool use_heading) {
  TrackedTrajectory trajectory;
  trajectory.points = headed_points(points, "points");
  trajectory.dt_s = dt_s;
  trajectory.use_heading = use_heading;
  require(uav.set_trajectory(trajectory));
}

py::dict trajectory_dict(const GeneratedTrajectory& trajectory) {
  if (!trajectory.is_valid) throw py::value_error(trajectory.message);
  py::dict out;
  out["points"] = point_rows(trajectory.samples);
  out["dt_s"] = trajectory.dt_s;
  out["duration_s"] = trajectory.duration_s;
  out["deviation_m"] = trajectory.deviation_m;
  out["waypoint_samples"] = trajectory.waypoint_samples;
  out["stops_at_corners"] = trajectory.stops_at_corners;
  return out;
}

py::dict generate(const py::array& waypoints, const std::string& constraints, double max_deviation_m,
                  bool stop_at_waypoints, double sampling_s) {
  PathRequest request;
  request.waypoints = headed_points(waypoints, "waypoints");
  request.limits = limits_named(constraints);
  request.max_deviation_m = max_deviation_m;
  request.stop_at_waypoints = stop_at_waypoints;
  TrajectoryGeneratorConfig config;
  config.sampling_s = sampling_s;
  GeneratedTrajectory trajectory;
  {
    const py::gil_scoped_release release;
    trajectory = generate_trajectory(base::checked(config), request);
  }
  return trajectory_dict(trajectory);
}

py::array_t<double> fly_through(Uav& uav, const py::array& waypoints, double max_deviation_m) {
  PathRequest request;
  request.waypoints = headed_points(waypoints, "waypoints");
  request.limits = uav.tracker().limits();
  request.max_deviation_m = max_deviation_m;
  request.start = uav.tracker().state();
  const GeneratedTrajectory generated = generate_trajectory({}, request);
  if (!generated.is_valid) throw py::value_error(generated.message);
  TrackedTrajectory trajectory;
  trajectory.points = generated.samples;
  trajectory.dt_s = generated.dt_s;
  require(uav.set_trajectory(trajectory));
  return point_rows(generated.samples);
}

py::array_t<double> prediction(Uav& uav) {
  std::vector<double> rows;
  for (int i = 0; i < 40; ++i) {
    const double ahead = 0.01 + 0.2 * i;
    const KinematicState& s = uav.predicted(ahead);
    rows.insert(rows.end(), {ahead, s.position.x(), s.position.y(), s.position.z(), s.heading_rad, s.velocity.x(),
                             s.velocity.y(), s.velocity.z()});
  }
  return array_from(std::move(rows), 8);
}

py::array_t<double> vector3(const Vec3& v) { return array_from(std::vector<double>{v.x(), v.y(), v.z()}, 0); }

const char* phase_name(const Uav& uav) {
  static const char* const names[] = {"idle", "taking off", "flying", "landing"};
  return names[static_cast<int>(uav.phase())];
}

void bind_state(py::class_<Uav>* cls) {
  cls->def_property_readonly("stamp_s", [](const Uav& u) { return base::to_seconds(u.stamp_ns()); })
      .def_property_readonly("phase", &phase_name, "idle, taking off, flying or landing.")
      .def_property_readonly(
          "truth", [](const Uav& u) { return pose_array(u.truth().pose); }, "T_W_B, (4, 4).")
      .def_property_readonly(
          "estimate", [](const Uav& u) { return pose_array(u.estimate().pose); }, "T_O_B, (4, 4).")
      .def_property_readonly(
          "velocity", [](const Uav& u) { return vector3(u.truth().velocity); }, "True, in W, m/s.")
      .def_property_readonly(
          "drift", [](const Uav& u) { return vector3(u.drift()); },
          "Position of the body in O minus that in W, m; jumps of the estimator included.")
      .def_property_readonly("estimator_iteration", &Uav::estimator_iteration, "How often the estimator was reset.")
      .def_property_readonly("is_repelled", &Uav::is_repelled, "Whether the bumper pushes the vehicle.")
      .def_property_readonly("is_avoiding", &Uav::is_avoiding, "Whether the vehicle climbs over another UAV.")
      .def_property_readonly("has_goal", [](const Uav& u) { return u.tracker().has_goal(); })
      .def_property_readonly(
          "height_m", [](const Uav& u) { return u.height_m(); }, "Above the ground; None outside.")
      .def("prediction", &prediction, "(40, 8): seconds ahead, x, y, z, heading, velocity, in O.");
}

void bind_uav_class(py::module_& m) {
  py::class_<Uav> cls(m, "Uav", "A simulated multirotor. Commands live in the drifting frame O of its estimate.");
  cls.def(py::init(&make_uav), py::arg("config") = UavConfig{}, py::arg("seed") = 0,
          py::arg("drift") = GnssDriftConfig{}, py::arg("imu") = ImuConfig{}, py::arg("constraints") = "medium",
          py::arg("scene") = nullptr, py::arg("faults") = UavFaults{})
      .def("step", &step, py::arg("duration_s"),
           "Advances time in steps of 0.005 s.\n\nReturns (n, 7) float64: stamp in s, angular velocity in rad/s and "
           "specific force in m/s^2, body frame, of every step.")
      .def(
          "take_off", [](Uav& u) { require(u.take_off()); }, "Raises ValueError with the reason when refused.")
      .def(
          "land", [](Uav& u) { require(u.land()); }, "Raises ValueError with the reason when refused.")
      .def(
          "hover", [](Uav& u) { require(u.hover()); }, "Brakes. Raises ValueError with the reason when refused.")
      .def(
          "go_to",
          [](Uav& u, const py::object& position, double heading) {
            require(u.go_to({vec3_of(position, "position"), heading}));
          },
          py::arg("position"), py::arg("heading_rad"))
      .def("set_trajectory", &set_trajectory, py::arg("points"), py::arg("dt_s") = 0.2, py::arg("use_heading") = true,
           "points: (n, 4) float64, x y z heading in O, every dt_s. Raises ValueError with the reason when refused.")
      .def("fly_through", &fly_through, py::arg("waypoints"), py::arg("max_deviation_m") = 0.2,
           "Generates and follows a trajectory from the present state; waypoints (n, 4) in O. Returns its samples.")
      .def(
          "set_constraints", [](Uav& u, const std::string& name) { u.set_limits(limits_named(name)); },
          py::arg("name"));
  bind_state(&cls);
}

void bind_faults(py::module_& m) {
  bind_config<TrackingConfig>(m, "TrackingConfig", "How the vehicle lags behind its tracker.");
  bind_config<WindConfig>(m, "WindConfig", "Mean wind and gusts.");
  bind_config<StateNoiseConfig>(m, "StateNoiseConfig", "Noise of the estimated state.");
  bind_config<RefusalsConfig>(m, "RefusalsConfig", "When references are refused.");
  bind_config<AvoidanceConfig>(m, "AvoidanceConfig", "Climbs over other UAVs.");
  bind_config<BumperConfig>(m, "BumperConfig", "Repulsion from near obstacles.");
  bind_config<EstimatorResetsConfig>(m, "EstimatorResetsConfig", "Jumps of the estimator's frame.");
  py::class_<UavFaults>(m, "UavFaults",
                        "What a real vehicle does differently from what it is told; all off by default.")
      .def(py::init<>())
      .def_readwrite("tracking", &UavFaults::tracking)
      .def_readwrite("wind", &UavFaults::wind)
      .def_readwrite("state_noise", &UavFaults::state_noise)
      .def_readwrite("refusals", &UavFaults::refusals)
      .def_readwrite("avoidance", &UavFaults::avoidance)
      .def_readwrite("bumper", &UavFaults::bumper)
      .def_readwrite("resets", &UavFaults::resets);
}

}  // namespace

void bind_uav(py::module_& m) {
  bind_faults(m);
  bind_config<UavConfig>(m, "UavConfig", "The simulated vehicle.");
  bind_config<GnssDriftConfig>(m, "GnssDriftConfig", "How the estimated pose drifts.");
  bind_config<ImuConfig>(m, "ImuConfig", "Bias and noise of the inertial unit.");
  bind_words<ConstraintSet>(m, "ConstraintSet", "Sets of limits of the constraint manager.");
  bind_config<UavConstraintsConfig>(m, "UavConstraintsConfig", "Named sets of speed, acceleration and jerk limits.");
  bind_config<TrajectoryGeneratorConfig>(m, "TrajectoryGeneratorConfig", "The trajectory generator.");
  bind_uav_class(m);
  m.def("generate_trajectory", &generate, py::arg("waypoints"), py::arg("constraints") = "medium",
        py::arg("max_deviation_m") = 0.2, py::arg("stop_at_waypoints") = false, py::arg("sampling_s") = 0.2,
        "Smooth trajectory from rest through (n, 4) waypoints. Returns a dict; raises ValueError with the reason.");
}

}  // namespace voxnav::bindings
