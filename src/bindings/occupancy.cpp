// SPDX-License-Identifier: BSD-3-Clause
#include <chrono>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "floors.hpp"
#include "moving_things.hpp"
#include "octomap_shift.hpp"
#include "voxnav/occupancy/local_map.hpp"
#include "voxnav/occupancy/octomap_export.hpp"

namespace voxnav::bindings {
namespace {

using occupancy::InsertStatistics;
using occupancy::LocalMap;
using occupancy::LocalMapConfig;
using occupancy::MapContent;

struct TimedStatistics : InsertStatistics {
  double seconds = 0.0;
};

geometry::PointsView points_of(const py::array& points, const char* name) {
  if (points.ndim() != 2 || (points.shape(1) != 3 && points.shape(1) != 4)) {
    throw py::value_error(std::string(name) + " must be a C-contiguous (n, 3) or (n, 4) array of float32");
  }
  return {data_of<float>(points, name, {-1, points.shape(1)}), static_cast<std::size_t>(points.shape(0)),
          static_cast<std::size_t>(points.shape(1))};
}

TimedStatistics insert(LocalMap& map, const py::array& points_L, const py::array& T_W_L, const py::object& no_returns) {
  const geometry::PointsView points = points_of(points_L, "points_L");
  const geometry::Pose pose = pose_of(T_W_L, "T_W_L");
  geometry::PointsView directions;
  py::array array;
  if (!no_returns.is_none()) {
    array = py::cast<py::array>(no_returns);
    directions = {data_of<float>(array, "no_return_directions", {-1, 3}), static_cast<std::size_t>(array.shape(0)), 3};
  }
  TimedStatistics out;
  py::gil_scoped_release release;
  const auto start = std::chrono::steady_clock::now();
  static_cast<InsertStatistics&>(out) = map.insert(points, pose, directions);
  out.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
  return out;
}

LocalMap load_octomap(const std::string& path, const LocalMapConfig& config, const py::object& center) {
  occupancy::OctomapCounts counts;
  LocalMap map = occupancy::load_octomap(path, config, vec3_of(center, "center_W"), &counts);
  const std::string of_all = " of " + std::to_string(counts.in_file) + " voxels of " + path;
  if (counts.outside_window > 0) {
    warn(std::to_string(counts.outside_window) + of_all + " lie outside the window and are left out");
  }
  if (counts.not_finite > 0) warn(std::to_string(counts.not_finite) + of_all + " have no finite log-odds");
  return map;
}

py::array_t<std::int8_t> states(const LocalMap& map, const py::array& points_W) {
  const float* points = data_of<float>(points_W, "points_W", {-1, 3});
  py::array_t<std::int8_t> out(points_W.shape(0));
  std::int8_t* data = out.mutable_data();
  for (py::ssize_t i = 0; i < points_W.shape(0); ++i) {
    const geometry::Vec3 p = Eigen::Map<const geometry::Vec3f>(points + 3 * i).cast<double>();
    data[i] = static_cast<std::int8_t>(map.state(p));
  }
  return out;
}

py::tuple corridor_state(const LocalMap& map, const py::object& a, const py::object& b, double radius_m) {
  const auto found = map.corridor_state(vec3_of(a, "a_W"), vec3_of(b, "b_W"), radius_m);
  const py::object first_bad = found.first_bad_m ? py::object(py::float_(*found.first_bad_m)) : py::object(py::none());
  return py::make_tuple(static_cast<int>(found.worst), first_bad);
}

py::object nearest_occupied(const LocalMap& map, const py::object& point, double max_distance_m) {
  const auto found = map.nearest_occupied(vec3_of(point, "point_W"), max_distance_m);
  if (!found) return py::none();
  const geometry::Vec3& p = found->point;
  return py::make_tuple(py::make_tuple(p.x(), p.y(), p.z()), found->distance_m);
}

py::tuple update_tuple(containers::GridUpdate&& update) {
  const auto count = static_cast<py::ssize_t>(update.block_indices.size() / 3);
  const auto bytes = static_cast<py::ssize_t>(containers::GridUpdate::kBytesPerBlock);
  py::array_t<std::uint8_t> states({count, bytes});
  std::copy(update.states.begin(), update.states.end(), states.mutable_data());
  return py::make_tuple(update.is_snapshot, array_from(std::move(update.block_indices), 3), states,
                        array_from(std::move(update.removed_block_indices), 3));
}

py::tuple new_hits(const LocalMap& map) {
  const std::vector<occupancy::NewHit>& hits = map.new_hits();
  const auto count = static_cast<py::ssize_t>(hits.size());
  py::array_t<float> points({count, py::ssize_t{3}});
  py::array_t<std::int32_t> returns(count);
  py::array_t<std::int8_t> states(count);
  for (py::ssize_t i = 0; i < count; ++i) {
    const occupancy::NewHit& hit = hits[static_cast<std::size_t>(i)];
    std::copy(hit.point.data(), hit.point.data() + 3, points.mutable_data() + 3 * i);
    returns.mutable_data()[i] = hit.num_points;
    states.mutable_data()[i] = static_cast<std::int8_t>(hit.state);
  }
  return py::make_tuple(points, returns, states);
}

void bind_statistics(py::module_& m) {
  py::class_<TimedStatistics>(m, "InsertStatistics", "Counts and wall time [s] of one insertion into a LocalMap.")
      .def_readonly("points", &TimedStatistics::points)
      .def_readonly("rejected_not_finite", &TimedStatistics::rejected_not_finite)
      .def_readonly("rejected_too_near", &TimedStatistics::rejected_too_near,
                    "Points nearer than min_range_m, those of zero range included.")
      .def_readonly("far", &TimedStatistics::far, "Points beyond max_range_m, which are no hits.")
      .def_readonly("outside_window", &TimedStatistics::outside_window)
      .def_readonly("cells_hit", &TimedStatistics::cells_hit)
      .def_readonly("cells_missed", &TimedStatistics::cells_missed)
      .def_readonly("cells_occupied", &TimedStatistics::cells_occupied, "Voxels that became occupied.")
      .def_readonly("cells_freed", &TimedStatistics::cells_freed, "Voxels that became free.")
      .def_readonly("cells_evicted", &TimedStatistics::cells_evicted)
      .def_readonly("blocks_evicted", &TimedStatistics::blocks_evicted)
      .def_readonly("window_cleared", &TimedStatistics::window_cleared, "True if the pose jumped beyond the window.")
      .def_readonly("seconds", &TimedStatistics::seconds);
}

void bind_content(py::module_& m) {
  py::class_<MapContent>(m, "MapContent",
                         "Known voxels of a local map with their mean hit points, from which a submap is made.")
      .def(py::init<>())
      .def_readonly("resolution_m", &MapContent::resolution_m)
      .def_property_readonly("num_blocks", [](const MapContent& c) { return c.blocks.size(); })
      .def_property_readonly("num_occupied", &MapContent::num_occupied)
      .def_property_readonly("memory_bytes", &MapContent::memory_bytes)
      .def("merge", &MapContent::merge, py::arg("newer"), "Voxels that `newer` knows replace those of this content.")
      .def(
          "occupied_points",
          [](const MapContent& c) {
            std::vector<float> out;
            for (const auto& block : c.blocks) {
              for (const auto& voxel : block.occupied) {
                const geometry::Vec3f p = occupancy::surface_point(block.index, voxel, c.resolution_m);
                out.insert(out.end(), p.data(), p.data() + 3);
              }
            }
            return array_from(std::move(out), 3);
          },
          "(k, 3) float32 mean hit points [m, frame of the map].")
      .def("to_bytes", [](const MapContent& c) { return py::bytes(c.to_bytes()); })
      .def_static("from_bytes", &MapContent::from_bytes, py::arg("bytes"));
}

void bind_queries(py::class_<LocalMap>& cls) {
  cls.def("states", &states, py::arg("points_W"),
          "(n,) int8 states (0 unknown, 1 free, 2 occupied) at (n, 3) float32 points [m].")
      .def("corridor_state", &corridor_state, py::arg("a_W"), py::arg("b_W"), py::arg("radius_m"),
           "Returns the worst state (occupied, unknown, free in this order) of all voxels that a ball of radius_m\n"
           "touches between two points, and the length [m] before it touches the first one that is not free (None if\n"
           "all are free).")
      .def(
          "box_state",
          [](const LocalMap& map, const py::object& low, const py::object& high) {
            return static_cast<int>(map.box_state({vec3_of(low, "min_W"), vec3_of(high, "max_W")}));
          },
          py::arg("min_W"), py::arg("max_W"), "Worst state of all voxels that an axis-aligned box touches.")
      .def(
          "ray_cast",
          [](const LocalMap& map, const py::object& a, const py::object& b, bool pass_unknown) {
            const auto found = map.ray_cast(vec3_of(a, "a_W"), vec3_of(b, "b_W"), pass_unknown);
            return py::make_tuple(static_cast<int>(found.state), found.range_m);
          },
          py::arg("a_W"), py::arg("b_W"), py::arg("pass_unknown") = false,
          "Returns (state, range [m]) of the first voxel from a to b that is occupied, or unknown unless pass_unknown.")
      .def("nearest_occupied", &nearest_occupied, py::arg("point_W"), py::arg("max_distance_m"),
           "((x, y, z), distance [m]) of the nearest mean hit point of an occupied voxel, None if there is none.");
}

void bind_outputs(py::class_<LocalMap>& cls) {
  cls.def(
         "occupied_points", [](const LocalMap& m) { return array_from(m.occupied_points(), 3); },
         "(k, 3) float32 mean hit point of every occupied voxel [m].")
      .def(
          "occupied_centers",
          [](const LocalMap& m, double threshold) { return array_from(m.centers_above(threshold), 3); },
          py::arg("threshold") = 0.8, "(k, 3) float32 centres of voxels above the probability.")
      .def(
          "free_centers", [](const LocalMap& m, double threshold) { return array_from(m.centers_below(threshold), 3); },
          py::arg("threshold") = 0.3, "(k, 3) float32 centres of voxels below the probability.")
      .def("new_hits", &new_hits,
           "Returns the hits of the newest scan in voxels that were believed to be free a short time ago, as (points\n"
           "(k, 3) float32 [m], returns (k,) int32, states after the scan (k,) int8).")
      .def_property_readonly("num_new_not_kept", &LocalMap::num_new_not_kept,
                             "Number of hits in free voxels that came when their block had no room to remember them.")
      .def_property_readonly("num_moving_not_kept", &LocalMap::num_moving_not_kept,
                             "How often a voxel was to be marked as moving beyond the number that is remembered.")
      .def("content", &LocalMap::content, "All known voxels as MapContent.")
      .def("hand_over", &LocalMap::hand_over,
           "Returns content() and begins a new submap: what is hit or crossed from here on counts as observed by it.")
      .def("take_evicted", &LocalMap::take_evicted,
           "Returns the content that left the window since the last call, as MapContent.")
      .def("to_bytes", [](const LocalMap& m) { return py::bytes(m.to_bytes()); })
      .def_static("from_bytes", &LocalMap::from_bytes, py::arg("bytes"))
      .def("save", &LocalMap::save, py::arg("path"))
      .def_static("load", &LocalMap::load, py::arg("path"))
      .def_static(
          "load_octomap", &load_octomap, py::arg("path"), py::arg("config") = LocalMapConfig{},
          py::arg("center_W") = py::make_tuple(0.0, 0.0, 0.0),
          "Reads a map from an OctoMap file (.ot, .bt) at the file's resolution, with its window around center_W.\n\n"
          "Warns (UserWarning) with the count of voxels that lie outside the window and are left out. Raises\n"
          "RuntimeError for other files, ConfigError when the window does not fit.")
      .def(
          "changes_since",
          [](const LocalMap& m, std::uint64_t sequence) { return update_tuple(m.changes_since(sequence)); },
          py::arg("sequence"),
          "Returns (is_snapshot, block indices (k, 3) int32, states (k, 1024) uint8, removed block indices (r, 3)\n"
          "int32) of the blocks that changed since the map had this sequence number; 0 gives all blocks.")
      .def_property_readonly("sequence", &LocalMap::sequence, "Rises with every call that may change the map.")
      .def(
          "save_octomap",
          [](const LocalMap& m, const std::string& path) { return said_shift(occupancy::save_octomap(m, path), path); },
          py::arg("path"),
          "Writes known voxels for OctoMap: .ot (log-odds) or .bt (binary).\n\n"
          "Returns None, or, for a map beyond the 2^15 voxels from the origin that an OctoMap reaches, (x, y, z) [m] "
          "to\n"
          "add to coordinates in the file to get those of the map, with a UserWarning; load_octomap() knows of it.");
}

}  // namespace

void bind_occupancy(py::module_& m) {
  bind_config<LocalMapConfig>(m, "LocalMapConfig", "Parameters of LocalMap.");
  bind_statistics(m);
  bind_content(m);
  py::class_<LocalMap> cls(m, "LocalMap", "Rolling three-state occupancy octree around a sensor. Not thread-safe.");
  cls.def(py::init<const LocalMapConfig&>(), py::arg("config") = LocalMapConfig{})
      .def("insert", &insert, py::arg("points_L"), py::arg("T_W_L"), py::arg("no_return_directions") = py::none(),
           "Moves the window to the sensor and inserts one scan.\n\n"
           "points_L: (n, 3) or (n, 4) float32 [m, sensor frame]; T_W_L: (4, 4) float64; no_return_directions: (m, 3)\n"
           "float32 of beams that returned nothing. Raises ValueError on other shapes and types.")
      .def(
          "mark_free",
          [](LocalMap& map, const py::object& center, double radius_m) {
            return map.mark_free(vec3_of(center, "center_W"), radius_m);
          },
          py::arg("center_W"), py::arg("radius_m"),
          "Marks voxels with centres inside a ball as free unless they are occupied, because the vehicle is there.\n\n"
          "Returns the number of voxels that became free.")
      .def("clear", &LocalMap::clear)
      .def("set_thresholds", &LocalMap::set_thresholds, py::arg("free_threshold"), py::arg("occupied_threshold"))
      .def_property_readonly("config", &LocalMap::config)
      .def_property_readonly("memory_bytes", &LocalMap::memory_bytes);
  bind_queries(cls);
  bind_outputs(cls);
  bind_moving_things(m);
}

}  // namespace voxnav::bindings
