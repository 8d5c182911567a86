// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "pybind.hpp"
#include "simulation_uav.hpp"
#include "voxnav_simulation/depth_camera.hpp"
#include "voxnav_simulation/lidar_model.hpp"
#include "voxnav_simulation/lidar_simulator_config.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav::bindings {
namespace {

using namespace voxnav_simulation;  // NOLINT: this file binds that namespace

Vec3 row(const double* data, py::ssize_t i) { return Vec3(data[3 * i], data[3 * i + 1], data[3 * i + 2]); }

py::object optional_pose(const std::optional<Pose>& pose) {
  if (!pose) return py::none();
  return pose_array(*pose);
}

/// @throws py::value_error unless the time is within what a stamp can hold
std::optional<StampNs> stamp_of(const std::optional<double>& stamp_s) {
  if (!stamp_s) return std::nullopt;
  if (!(std::abs(*stamp_s) < 1e9)) throw py::value_error("stamp_s must be within 1e9 seconds of 0");
  return base::from_seconds(*stamp_s);
}

py::array_t<double> clearance(const Scene& scene, const py::array& points, double max_m,
                              const std::optional<double>& stamp_s) {
  const auto at_ns = stamp_of(stamp_s);
  const double* data = data_of<double>(points, "points", {-1, 3});
  std::vector<double> out(static_cast<std::size_t>(points.shape(0)));
  {
    const py::gil_scoped_release release;
    for (std::size_t i = 0; i < out.size(); ++i)
      out[i] = scene.clearance(row(data, static_cast<py::ssize_t>(i)), max_m, at_ns);
  }
  return array_from(std::move(out), 0);
}

py::tuple nearest(const Scene& scene, const py::array& points, double max_m) {
  const double* data = data_of<double>(points, "points", {-1, 3});
  const auto count = static_cast<std::size_t>(points.shape(0));
  std::vector<double> distances(count, std::numeric_limits<double>::quiet_NaN());
  std::vector<std::uint8_t> classes(count, kLabelNone);
  {
    const py::gil_scoped_release release;
    for (std::size_t i = 0; i < count; ++i) {
      const auto found = scene.nearest(row(data, static_cast<py::ssize_t>(i)), max_m);
      if (!found) continue;
      distances[i] = found->distance_m;
      classes[i] = static_cast<std::uint8_t>(found->surface_class);
    }
  }
  return py::make_tuple(array_from(std::move(distances), 0), array_from(std::move(classes), 0));
}

py::tuple cast(const Scene& scene, const py::array& origins, const py::array& directions, double max_range_m) {
  const double* from = data_of<double>(origins, "origins", {-1, 3});
  const double* along = data_of<double>(directions, "directions", {origins.shape(0), 3});
  const auto count = static_cast<std::size_t>(origins.shape(0));
  std::vector<float> ranges(count), cosines(count);
  std::vector<std::uint8_t> classes(count, kLabelNone);
  {
    const py::gil_scoped_release release;
    for (std::size_t i = 0; i < count; ++i) {
      const auto k = static_cast<py::ssize_t>(i);
      const Vec3f direction = row(along, k).normalized().cast<float>();
      Hit hit;
      scene.cast(row(from, k).cast<float>(), &direction, 1, static_cast<float>(max_range_m), &hit);
      ranges[i] = hit.range_m;
      cosines[i] = hit.cos_incidence;
      if (hit.is_hit()) classes[i] = static_cast<std::uint8_t>(hit.surface_class);
    }
  }
  return py::make_tuple(array_from(std::move(ranges), 0), array_from(std::move(classes), 0),
                        array_from(std::move(cosines), 0));
}

py::dict mesh_arrays(const Scene& scene) {
  WorldMesh mesh = scene.world().mesh();
  if (const auto pose = scene.vehicle_pose()) append_mesh(&mesh, scene.world().vehicle_mesh(), *pose);
  std::vector<float> vertices;
  for (const Vec3f& v : mesh.vertices) vertices.insert(vertices.end(), {v.x(), v.y(), v.z()});
  std::vector<std::uint32_t> triangles;
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  std::vector<std::uint8_t> classes;
  for (const SurfaceClass c : mesh.classes) classes.push_back(static_cast<std::uint8_t>(c));
  py::dict out;
  out["vertices"] = array_from(std::move(vertices), 3);
  out["triangles"] = array_from(std::move(triangles), 3);
  out["classes"] = array_from(std::move(classes), 0);
  return out;
}

py::array_t<double> mover_rows(const Scene& scene, double stamp_s) {
  const StampNs at_ns = *stamp_of(stamp_s);
  std::vector<double> out;
  for (const Mover& mover : scene.world().movers()) {
    const Vec3 p = mover.at(at_ns);
    out.insert(out.end(),
               {p.x(), p.y(), p.z(), mover.radius_m, mover.height_m, static_cast<double>(mover.surface_class)});
  }
  return array_from(std::move(out), 6);
}

py::array_t<double> stem_rows(const Scene& scene) {
  std::vector<double> out;
  for (const Stem& stem : scene.world().stems()) {
    const Rod& r = stem.rod;
    out.insert(out.end(), {r.a.x(), r.a.y(), r.a.z(), r.b.x(), r.b.y(), r.b.z(), r.radius_a_m, r.radius_b_m,
                           static_cast<double>(stem.surface_class)});
  }
  return array_from(std::move(out), 9);
}

py::array_t<double> ground_height(const Scene& scene, const py::array& points) {
  const double* data = data_of<double>(points, "points", {-1, 2});
  std::vector<double> out;
  for (py::ssize_t i = 0; i < points.shape(0); ++i) {
    out.push_back(scene.world().ground_height(data[2 * i], data[2 * i + 1]).value_or(std::nan("")));
  }
  return array_from(std::move(out), 0);
}

py::dict counts(const Scene& scene) {
  const WorldCounts& c = scene.world().counts();
  py::dict out;
  out["trees"] = c.num_trees;
  out["bushes"] = c.num_bushes;
  out["poles"] = c.num_poles;
  out["rocks"] = c.num_rocks;
  out["walls"] = c.num_walls;
  out["houses"] = c.num_houses;
  return out;
}

py::dict scan_arrays(LidarScan&& scan) {
  std::vector<float> points;
  points.reserve(4 * scan.points.size());
  for (const auto& p : scan.points) points.insert(points.end(), p.begin(), p.end());
  py::dict out;
  const std::vector<py::ssize_t> shape{scan.rows, scan.columns};
  out["points"] = array_from(std::move(points), {scan.rows, scan.columns, 4});
  out["ranges_m"] = array_from(std::move(scan.ranges_m), shape);
  out["labels"] = array_from(std::move(scan.labels), shape);
  out["column_times_ns"] = array_from(std::move(scan.column_times_ns), 0);
  return out;
}

py::dict scan_between(const LidarModel& lidar, const Scene& scene, const py::array& start, const py::array& end,
                      std::uint64_t scan_index) {
  const Pose T_start = pose_of(start, "T_W_L_start"), T_end = pose_of(end, "T_W_L_end");
  LidarScan scan;
  {
    const py::gil_scoped_release release;
    scan = lidar.scan(scene, poses_between(T_start, T_end, lidar.config().columns), scan_index);
  }
  return scan_arrays(std::move(scan));
}

void bind_scene(py::module_& m) {
  py::class_<Scene, std::shared_ptr<Scene>>(m, "Scene", "A generated world, ready for ray casting. Frame W, metres.")
      .def(py::init([](const WorldConfig& config, std::uint64_t seed) {
             const py::gil_scoped_release release;
             return std::make_shared<Scene>(World(config, seed));
           }),
           py::arg("config"), py::arg("seed"))
      .def(
          "save_ply", [](const Scene& s, const std::string& path) { save_ply(s.world(), s.vehicle_pose(), path); },
          py::arg("path"))
      .def("ground_height", &ground_height, py::arg("points"))
      .def("clearance", &clearance, py::arg("points"), py::arg("max_m"), py::arg("stamp_s") = py::none())
      .def("movers", &mover_rows, py::arg("stamp_s"))
      .def("nearest", &nearest, py::arg("points"), py::arg("max_m"))
      .def("cast", &cast, py::arg("origins"), py::arg("directions"), py::arg("max_range_m"))
      .def("move_vehicle", &Scene::move_vehicle, py::arg("x"), py::arg("y"), py::arg("heading_rad"))
      .def("vehicle_pose", [](const Scene& s) { return optional_pose(s.vehicle_pose()); })
      .def("mesh", &mesh_arrays)
      .def("stems", &stem_rows)
      .def("counts", &counts)
      .def_property_readonly("config", [](const Scene& s) { return s.world().config(); })
      .def_property_readonly("seed", [](const Scene& s) { return s.world().seed(); });
}

void bind_lidar(py::module_& m) {
  py::class_<LidarModel>(m, "LidarModel", "A LiDAR that measures a Scene.")
      .def(py::init<const LidarConfig&, std::uint64_t>(), py::arg("config"), py::arg("seed"))
      .def("scan", &scan_between, py::arg("scene"), py::arg("T_W_L_start"), py::arg("T_W_L_end"), py::arg("scan_index"))
      .def_property_readonly("config", [](const LidarModel& l) { return l.config(); })
      .def_property_readonly("sweep_s", [](const LidarModel& l) { return 1e-9 * static_cast<double>(l.sweep_ns()); });
}

py::array_t<float> image_of(const DepthCameraModel& camera, const Scene& scene, const py::array& T_W_C,
                            std::uint64_t index) {
  const Pose pose = pose_of(T_W_C, "T_W_C");
  DepthPixels pixels;
  {
    const py::gil_scoped_release release;
    pixels = camera.image(scene, pose, index);
  }
  return array_from(std::move(pixels), {camera.config().height, camera.config().width});
}

void bind_depth_camera(py::module_& m) {
  py::class_<DepthCameraModel>(m, "DepthCameraModel", "A depth camera that measures a Scene.")
      .def(py::init<const DepthCameraConfig&, std::uint64_t>(), py::arg("config"), py::arg("seed"))
      .def("image", &image_of, py::arg("scene"), py::arg("T_W_C"), py::arg("index"),
           "(h, w) float32 depth along the optical axis [m], 0 = none.")
      .def_property_readonly("config", [](const DepthCameraModel& c) { return c.config(); })
      .def_property_readonly(
          "T_B_C", [](const DepthCameraModel& c) { return pose_array(c.config().T_B_C()); },
          "(4, 4) float64 pose of the optical frame on the body.")
      .def_property_readonly(
          "K",
          [](const DepthCameraModel& c) {
            const cloud::CameraModel camera = c.config().camera();
            return array_from(std::vector<double>{camera.fx, 0, camera.cx, 0, camera.fy, camera.cy, 0, 0, 1}, 3);
          },
          "(3, 3) float64 intrinsics.");
}

}  // namespace
}  // namespace voxnav::bindings

PYBIND11_MODULE(_simulation, m) {
  namespace vb = voxnav::bindings;
  m.doc() = "The simulator's world and LiDAR; use it through voxnav.simulation.";
  pybind11::module_::import("voxnav._core");  // registers ConfigError
  vb::bind_config<voxnav_simulation::WorldConfig>(m, "WorldConfig", "The contents of a generated world.");
  vb::bind_words<voxnav_simulation::BeamModel>(m, "BeamModel", "Beam tables of data sheets, or a custom one.");
  vb::bind_words<voxnav_simulation::DriverLayout>(m, "DriverLayout", "Layouts of the simulated clouds.");
  vb::bind_config<voxnav_simulation::LidarConfig>(m, "LidarConfig", "A spinning LiDAR and its errors.");
  vb::bind_config<voxnav_simulation::LidarSimulatorConfig>(m, "LidarSimulatorConfig", "The lidar_simulator node.");
  vb::bind_config<voxnav_simulation::DepthCameraConfig>(m, "DepthCameraConfig",
                                                        "A stereo depth camera and its errors.");
  m.def("load_world_config", &voxnav_simulation::load_world_config, pybind11::arg("path"),
        "Reads a WorldConfig from a flat YAML file. Raises ConfigError that lists every problem.");
  vb::bind_scene(m);
  vb::bind_lidar(m);
  vb::bind_depth_camera(m);
  vb::bind_uav(m);
  pybind11::dict classes;
  for (int i = 0; i < voxnav_simulation::kNumSurfaceClasses; ++i) {
    classes[voxnav_simulation::name_of(static_cast<voxnav_simulation::SurfaceClass>(i))] = i;
  }
  classes["own_body"] = voxnav_simulation::kLabelOwnBody;
  classes["ghost"] = voxnav_simulation::kLabelGhost;
  classes["rain"] = voxnav_simulation::kLabelRain;
  classes["speckle"] = voxnav_simulation::kLabelSpeckle;
  classes["none"] = voxnav_simulation::kLabelNone;
  m.attr("CLASSES") = classes;
}
