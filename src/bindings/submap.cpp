// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/submap.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <map>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "floors.hpp"
#include "submap_collection.hpp"
#include "voxnav/submap/mesh.hpp"
#include "voxnav/submap/projective_integrator.hpp"

namespace voxnav::bindings {
namespace {

using occupancy::MapContent;
using submap::ProjectiveConfig;
using submap::ProjectiveIntegrator;
using submap::Submap;
using submap::SubmapConfig;

std::shared_ptr<Submap> from_content(const MapContent& content, const py::array& T_S_G, const SubmapConfig& config) {
  const geometry::Pose pose = pose_of(T_S_G, "T_S_G");
  py::gil_scoped_release release;
  return Submap::from_content(content, pose, config);
}

std::shared_ptr<Submap> from_local_map(const py::object& map, const py::array& T_W_S, const SubmapConfig& config) {
  const geometry::Pose pose = pose_of(T_W_S, "T_W_S");
  const py::object content_object = map.attr("content")();
  const auto& content = content_object.cast<const MapContent&>();
  py::gil_scoped_release release;
  return Submap::from_content(content, pose.inverse(Eigen::Isometry), config);
}

std::shared_ptr<geometry::DistanceField> registration_field_of(const std::shared_ptr<Submap>& submap,
                                                               const py::object& stamps_s, const py::object& T_S_B) {
  std::vector<geometry::StampedPose> history;
  if (!stamps_s.is_none()) history = stamped_poses_of(stamps_s.cast<py::array>(), T_S_B.cast<py::array>(), "T_S_B");
  py::gil_scoped_release release;
  // pybind11 holders are not const; fields have no method that changes them.
  return std::const_pointer_cast<geometry::DistanceField>(submap::registration_field(submap, history));
}

/// Reads the surface points of occupied voxels, one row each. With None every point is the centre of its voxel.
class PointRows {
 public:
  PointRows(const py::object& points, double resolution_m) : resolution_m_(resolution_m) {
    if (points.is_none()) return;
    array_ = py::cast<py::array>(points);
    rows_ = data_of<float>(array_, "points", {-1, 3});
    size_ = array_.shape(0);
  }
  std::array<std::int8_t, 3> next(const geometry::Index3& voxel) {
    if (!rows_) return {0, 0, 0};
    if (next_ >= size_) throw py::value_error("points must hold one row per occupied voxel");
    const geometry::Vec3 p = Eigen::Map<const geometry::Vec3f>(rows_ + 3 * next_++).cast<double>();
    const geometry::Vec3 mean = (p - geometry::center_of(voxel, resolution_m_)) * (254.0 / resolution_m_);
    if (!(mean.array().abs() <= 127.5f).all()) throw py::value_error("a surface point lies outside its voxel");
    std::array<std::int8_t, 3> out;
    for (int k = 0; k < 3; ++k)
      out[k] = static_cast<std::int8_t>(std::lround(std::min(127.0, std::max(-127.0, mean[k]))));
    return out;
  }
  void check_all_used() const {
    if (rows_ && next_ != size_) throw py::value_error("points must hold one row per occupied voxel");
  }

 private:
  double resolution_m_;
  py::array array_;
  const float* rows_ = nullptr;
  py::ssize_t size_ = 0;
  py::ssize_t next_ = 0;
};

using ContentBlocks = std::map<geometry::Index3, occupancy::ContentBlock>;

MapContent content_of(ContentBlocks&& blocks, double resolution_m) {
  MapContent content;
  content.resolution_m = resolution_m;
  for (auto& item : blocks) {
    std::sort(item.second.occupied.begin(), item.second.occupied.end(),
              [](const auto& a, const auto& b) { return a.offset < b.offset; });
    content.blocks.push_back(std::move(item.second));
  }
  return content;
}

MapContent content_from_array(const py::array& states, const py::object& origin, double resolution_m,
                              const py::object& points, int hits) {
  if (states.ndim() != 3) throw py::value_error("states must be a (nx, ny, nz) array of int8");
  if (!(resolution_m > 0.0)) throw py::value_error("resolution_m must be positive");
  if (hits < 1 || hits > 255) throw py::value_error("hits must be from 1 to 255");
  const auto* data = data_of<std::int8_t>(states, "states", {-1, -1, -1});
  PointRows rows(points, resolution_m);
  const geometry::Vec3 inside_first = vec3_of(origin, "origin") + geometry::Vec3::Constant(0.5 * resolution_m);
  const geometry::Index3 first = geometry::index_of(inside_first, resolution_m);
  ContentBlocks blocks;
  for (py::ssize_t i = 0; i < states.size(); ++i) {
    if (data[i] < 0 || data[i] > 2)
      throw py::value_error("states holds a value other than 0 unknown, 1 free, 2 occupied");
    if (data[i] == 0) continue;
    const auto z = static_cast<std::int32_t>(i % states.shape(2));
    const auto y = static_cast<std::int32_t>(i / states.shape(2) % states.shape(1));
    const auto x = static_cast<std::int32_t>(i / states.shape(2) / states.shape(1));
    const geometry::Index3 voxel = first + geometry::Index3{x, y, z};
    occupancy::ContentBlock& block = blocks[geometry::block_of(voxel)];
    block.index = geometry::block_of(voxel);
    const auto offset = static_cast<std::uint16_t>(geometry::offset_in_block(voxel));
    block.states.set(offset, static_cast<containers::VoxelState>(data[i]));
    if (data[i] == 1) block.observed_free[offset >> 6] |= std::uint64_t{1} << (offset & 63);
    if (data[i] != 2) continue;
    const auto mean = rows.next(voxel);
    const auto num_hits = static_cast<std::uint8_t>(hits);
    block.occupied.push_back({offset, {mean, num_hits}, {mean, num_hits}});
  }
  rows.check_all_used();
  return content_of(std::move(blocks), resolution_m);
}

py::dict integrate(ProjectiveIntegrator& integrator, const py::array& points_L, const py::array& T_S_L) {
  const float* data = data_of<float>(points_L, "points_L", {-1, 3});
  const geometry::Pose pose = pose_of(T_S_L, "T_S_L");
  std::vector<geometry::Vec3f> points(static_cast<std::size_t>(points_L.shape(0)));
  if (!points.empty()) std::memcpy(points[0].data(), data, points.size() * 3 * sizeof(float));
  ProjectiveIntegrator::Counts counts;
  {
    py::gil_scoped_release release;
    counts = integrator.integrate(points, pose);
  }
  py::dict out;
  out["points"] = counts.points;
  out["dropped"] = counts.dropped;
  out["rays"] = counts.rays;
  out["voxels"] = counts.voxels;
  out["refused"] = counts.refused;
  return out;
}

void bind_configs(py::module_& m) {
  bind_config<SubmapConfig>(m, "SubmapConfig", "Parameters of a Submap and its distances.");
  bind_words<submap::RayRule>(m, "RayRule", "Which rays of a scan ProjectiveIntegrator casts.");
  bind_words<submap::RangeWeighting>(m, "RangeWeighting", "How the weight of a point depends on its range.");
  bind_config<ProjectiveConfig>(m, "ProjectiveConfig", "Parameters of ProjectiveIntegrator.");
}

void bind_one_submap(py::module_& m) {
  py::class_<Submap, geometry::DistanceField, std::shared_ptr<Submap>>(
      m, "Submap", "A finished submap with its states, surface points and distances, frame S. Immutable.")
      .def_static("from_local_map", &from_local_map, py::arg("m"), py::arg("T_W_S"), py::arg("config") = SubmapConfig{},
                  "Makes a submap of the whole content of a LocalMap.\n\n"
                  "T_W_S: (4, 4) float64, submap frame in the frame of the map's poses.")
      .def_static("from_content", &from_content, py::arg("content"), py::arg("T_S_G"),
                  py::arg("config") = SubmapConfig{},
                  "Makes a submap of a MapContent.\n\nT_S_G: (4, 4) float64, frame of the content in the submap frame.")
      .def(
          "states",
          [](const Submap& s, const py::array& points_S) {
            const float* p = data_of<float>(points_S, "points_S", {-1, 3});
            py::array_t<std::int8_t> out(points_S.shape(0));
            for (py::ssize_t i = 0; i < out.size(); ++i) {
              out.mutable_data()[i] = static_cast<std::int8_t>(s.state({p[3 * i], p[3 * i + 1], p[3 * i + 2]}));
            }
            return out;
          },
          py::arg("points_S"), "(n,) int8 states (0 unknown, 1 free, 2 occupied) of (n, 3) float32 points [m].")
      .def(
          "occupied_points", [](const Submap& s) { return rows_of(s.occupied_points()); },
          "(k, 3) float32 surface point of every occupied voxel [m, frame S].")
      .def(
          "mesh", [](const Submap& s) { return mesh_tuple(submap::extract_mesh(s)); },
          "(vertices (k, 3) float32 [m, frame S], triangles (t, 3) uint32), counter-clockwise seen from free space.")
      .def("registration_field", &registration_field_of, py::arg("stamps_s") = py::none(),
           py::arg("T_S_B") = py::none(),
           "Returns the DistanceField by which this submap is registered to others. It holds what the submap observed\n"
           "itself, without what its local map remembered from before.\n\n"
           "stamps_s: (n,), T_S_B: (n, 4, 4): pose history of the submap. If it is given, thin things such as trunks\n"
           "are registered by their middles, else by the side from which they were hit (docs/alignment.md).")
      .def_property_readonly("memory_bytes", &Submap::memory_bytes)
      .def_property_readonly("T_S_G", [](const Submap& s) { return pose_array(s.T_S_G()); })
      .def(
          "to_bytes", [](const Submap& s) { return py::bytes(s.to_bytes()); },
          "Serialises the submap with a version and a checksum.")
      .def_static(
          "from_bytes", [](const py::bytes& b) { return Submap::from_bytes(b); }, py::arg("b"),
          "Reads a submap from the bytes of to_bytes(). Raises ValueError with the reason if they are truncated or "
          "corrupt.");
}

void bind_integrator(py::module_& m) {
  py::class_<ProjectiveIntegrator>(m, "ProjectiveIntegrator",
                                   "Truncated signed distances along rays (TSDF), one submap at a time.")
      .def(py::init<const ProjectiveConfig&>(), py::arg("config") = ProjectiveConfig{})
      .def("integrate", &integrate, py::arg("points_L"), py::arg("T_S_L"),
           "Fuses one scan. points_L: (n, 3) float32 [m, sensor frame]; T_S_L: (4, 4) float64.\n\n"
           "Returns counts: points, dropped, rays, voxels, refused.")
      .def(
          "finish", [](ProjectiveIntegrator& i, const SubmapConfig& config) { return i.finish(config); },
          py::arg("config") = SubmapConfig{}, py::call_guard<py::gil_scoped_release>(),
          "Returns the Submap and leaves the integrator empty.");
}

}  // namespace

py::array_t<float> rows_of(const std::vector<geometry::Vec3f>& points) {
  std::vector<float> out;
  out.reserve(3 * points.size());
  for (const geometry::Vec3f& p : points) out.insert(out.end(), p.data(), p.data() + 3);
  return array_from(std::move(out), 3);
}

py::tuple mesh_tuple(const submap::Mesh& mesh) {
  std::vector<std::uint32_t> triangles;
  triangles.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) triangles.insert(triangles.end(), t.begin(), t.end());
  return py::make_tuple(rows_of(mesh.vertices), array_from(std::move(triangles), 3));
}

void bind_submap(py::module_& m) {
  bind_configs(m);
  bind_one_submap(m);
  bind_integrator(m);
  bind_submap_collection(m);
  m.def(
      "set_distance_cache_mb",
      [](int megabytes) {
        if (megabytes < 1) throw py::value_error("the cache needs at least 1 MB");
        Submap::set_distance_cache_bytes(static_cast<std::size_t>(megabytes) << 20);
      },
      py::arg("megabytes"),
      "Sets the size of the cache of distances that all submaps of this process share (24 MB by default). Distances "
      "that do not fit are computed again when they are asked for; the answers stay the same.");
  m.def("map_content_from_array", &content_from_array, py::arg("states"), py::arg("origin"), py::arg("resolution_m"),
        py::arg("points") = py::none(), py::arg("hits") = 10,
        "Makes a MapContent from a dense (nx, ny, nz) int8 array (0 unknown, 1 free, 2 occupied).\n\n"
        "origin: (3,) lowest corner of voxel [0, 0, 0], snapped to the grid; points: (k, 3) float32 surface points of\n"
        "the occupied voxels in array order, voxel centres if None; hits: number of hits of each occupied voxel.");
}

}  // namespace voxnav::bindings
