// SPDX-License-Identifier: BSD-3-Clause
#include "submap_collection.hpp"

#include <pybind11/stl.h>

#include <algorithm>
#include <fstream>
#include <limits>
#include <optional>

#include "arrays.hpp"
#include "bind_config.hpp"
#include "octomap_shift.hpp"
#include "voxnav/submap/obstacle_map.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::bindings {
namespace {

using submap::ObstacleMap;
using submap::Submap;
using submap::SubmapCollection;
using submap::SubmapCollectionConfig;
using submap::SubmapEntry;

void add(SubmapCollection& collection, std::uint32_t id, std::shared_ptr<Submap> submap, const py::array& T_W_S,
         double stamp, const py::object& bend) {
  SubmapEntry entry;
  entry.id = id;
  entry.T_W_S = pose_of(T_W_S, "T_W_S");
  entry.T_O_S = entry.T_W_S;
  entry.bend = bend_of(bend);
  entry.end_ns = base::from_seconds(stamp);
  entry.submap = std::move(submap);
  collection.add(std::move(entry));
}

std::optional<geometry::Vec3> write_octomap(SubmapCollection* collection, const std::string& path) {
  const py::gil_scoped_release release;
  collection->update();
  return submap::save_octomap(collection->evidence(), path);
}

std::optional<geometry::Vec3> export_into(SubmapCollection* collection, const std::string& directory) {
  const py::gil_scoped_release release;
  return submap::export_all(collection, directory);
}

py::dict poses(const SubmapCollection& collection) {
  py::dict out;
  for (const SubmapEntry* entry : collection.entries()) out[py::int_(entry->id)] = pose_array(entry->T_W_S);
  return out;
}

py::dict bends(const SubmapCollection& collection) {
  py::dict out;
  for (const SubmapEntry* entry : collection.entries()) {
    py::list both;
    both.append(pose_array(entry->bend.T_S_begin));
    both.append(pose_array(entry->bend.T_S_end));
    out[py::int_(entry->id)] = py::module_::import("numpy").attr("stack")(both);
  }
  return out;
}

void set_poses(SubmapCollection& collection, const py::dict& poses, const py::dict& bends) {
  for (const auto& item : poses) {
    const auto id = item.first.cast<std::uint32_t>();
    const geometry::Pose T_W_S = pose_of(item.second.cast<py::array>(), "T_W_S");
    if (!collection.set_pose(id, T_W_S, bend_of(bends.attr("get")(item.first))))
      throw py::key_error(std::to_string(id));
  }
}

py::array_t<double> distance(SubmapCollection& collection, const py::array& points_W, double max_distance_m) {
  const float* p = data_of<float>(points_W, "points_W", {-1, 3});
  std::vector<double> out(static_cast<std::size_t>(points_W.shape(0)), std::numeric_limits<double>::quiet_NaN());
  {
    py::gil_scoped_release release;
    collection.update();
    for (std::size_t i = 0; i < out.size(); ++i) {
      const geometry::Vec3 point(p[3 * i], p[3 * i + 1], p[3 * i + 2]);
      if (collection.evidence().state(point) == containers::VoxelState::kUnknown) continue;
      out[i] = collection.evidence().distance_to_surface(point, max_distance_m).value_or(max_distance_m);
    }
  }
  return array_from(std::move(out), 0);
}

py::array_t<double> gradient(SubmapCollection& collection, const py::array& points_W, double max_distance_m) {
  const float* p = data_of<float>(points_W, "points_W", {-1, 3});
  std::vector<double> out(3 * static_cast<std::size_t>(points_W.shape(0)), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < out.size(); i += 3) {
    const auto slope = collection.gradient({p[i], p[i + 1], p[i + 2]}, max_distance_m);
    if (slope) std::copy_n(slope->data(), 3, &out[i]);
  }
  return array_from(std::move(out), 3);
}

py::list changes(SubmapCollection& collection, std::size_t min_voxels) {
  py::list out;
  for (const submap::SceneChange& change : collection.changes(min_voxels)) {
    py::dict item;
    item["kind"] = change.kind == submap::SceneChange::Kind::kAppeared ? "appeared" : "disappeared";
    item["center"] = py::make_tuple(change.center_W.x(), change.center_W.y(), change.center_W.z());
    item["box_min"] = py::make_tuple(change.box_W.min.x(), change.box_W.min.y(), change.box_W.min.z());
    item["box_max"] = py::make_tuple(change.box_W.max.x(), change.box_W.max.y(), change.box_W.max.z());
    item["voxels"] = change.num_voxels;
    item["submap"] = change.submap_id;
    out.append(item);
  }
  return out;
}

py::array_t<std::int8_t> states(SubmapCollection& collection, const py::array& points_W) {
  const float* p = data_of<float>(points_W, "points_W", {-1, 3});
  py::array_t<std::int8_t> out(points_W.shape(0));
  collection.update();
  for (py::ssize_t i = 0; i < out.size(); ++i) {
    out.mutable_data()[i] =
        static_cast<std::int8_t>(collection.evidence().state({p[3 * i], p[3 * i + 1], p[3 * i + 2]}));
  }
  return out;
}

py::array_t<float> obstacle_centers(SubmapCollection& collection, double safety_distance_m) {
  std::vector<geometry::Vec3f> out;
  {
    py::gil_scoped_release release;
    const containers::StateGrid grid = collection.obstacles(safety_distance_m);
    for (const geometry::Index3& index : grid.sorted_block_indices()) {
      const containers::StateBlock* block = grid.find_block(index);
      for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
        if (block->get(offset) != containers::VoxelState::kOccupied) continue;
        out.emplace_back(geometry::center_of(geometry::voxel_at(index, offset), grid.resolution_m()).cast<float>());
      }
    }
  }
  return rows_of(out);
}

py::tuple colored_mesh(SubmapCollection& collection) {
  const submap::Mesh mesh = submap::extract_mesh(&collection);
  std::vector<std::uint8_t> colors;
  for (const submap::Color& color : mesh.colors) colors.insert(colors.end(), color.begin(), color.end());
  const py::tuple geometry = mesh_tuple(mesh);
  return py::make_tuple(geometry[0], geometry[1], array_from(std::move(colors), 3));
}

void save_mesh(SubmapCollection& collection, const std::string& path) {
  std::ofstream out(path, std::ios::binary);
  const std::string bytes = submap::to_ply(submap::extract_mesh(&collection));
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

py::object load(const std::string& directory, bool recover, const SubmapCollectionConfig* config) {
  std::vector<std::string> problems;
  SubmapCollection collection = SubmapCollection::load(directory, recover ? &problems : nullptr, config);
  py::object out = py::cast(std::move(collection));
  return recover ? py::object(py::make_tuple(out, problems)) : out;
}

py::dict update_obstacles(ObstacleMap& obstacles, SubmapCollection& collection) {
  containers::GridUpdate changes;
  {
    py::gil_scoped_release release;
    obstacles.mark_changed(collection.update());
    obstacles.update(collection.evidence(), std::numeric_limits<std::size_t>::max());
    changes = obstacles.take_changes();
  }
  py::dict out;
  out["block_indices"] = array_from(std::move(changes.block_indices), 3);
  out["states"] = py::bytes(reinterpret_cast<const char*>(changes.states.data()), changes.states.size());
  out["removed"] = array_from(std::move(changes.removed_block_indices), 3);
  out["is_snapshot"] = false;
  return out;
}

void bind_obstacles(py::module_& m) {
  py::class_<ObstacleMap>(m, "ObstacleMap",
                          "Obstacles: voxels nearer to a surface than the safety distance, updated block by block.")
      .def(py::init<double, double>(), py::arg("resolution_m"), py::arg("safety_distance_m"))
      .def("update", &update_obstacles, py::arg("collection"),
           "Updates the obstacles with the changes of the collection since the last call. Always pass the same one.\n\n"
           "Returns the changed blocks as keywords of StateGrid.apply_update().")
      .def(
          "grid", [](const ObstacleMap& o) { return o.grid(); },
          "Returns a copy of all obstacles as StateGrid, frame W.")
      .def_property_readonly("memory_bytes", &ObstacleMap::memory_bytes);
}

void bind_queries(py::class_<SubmapCollection>& cls) {
  cls.def(
         "occupied_points", [](SubmapCollection& c) { return rows_of(c.occupied_points()); },
         "(k, 3) float32 surface points that are still believed [m, frame W].")
      .def("obstacles", &obstacle_centers, py::arg("safety_distance_m"),
           "(k, 3) float32 centres of voxels nearer to a surface than the safety distance [m, frame W].")
      .def("obstacle_grid", &SubmapCollection::obstacles, py::arg("safety_distance_m"),
           py::call_guard<py::gil_scoped_release>(),
           "Returns the obstacles as StateGrid: occupied = nearer to a surface than the safety distance, free = known "
           "to\n"
           "be free and farther, else unknown.")
      .def("distance", &distance, py::arg("points_W"), py::arg("max_distance_m") = 10.0,
           "(n,) float64 distance [m] to the nearest believed surface point; max_distance_m beyond it, NaN where the\n"
           "map is unknown.")
      .def("gradient", &gradient, py::arg("points_W"), py::arg("max_distance_m") = 10.0,
           "(n, 3) float64 unit vectors away from the nearest believed surface point; zero beyond max_distance_m, NaN\n"
           "where the map is unknown.")
      .def(
          "cast_ray",
          [](SubmapCollection& c, const py::object& a_W, const py::object& b_W) {
            const auto ray = c.cast_ray(vec3_of(a_W, "a_W"), vec3_of(b_W, "b_W"));
            return py::make_tuple(static_cast<int>(ray.state), ray.distance_m);
          },
          py::arg("a_W"), py::arg("b_W"),
          "(state, distance [m]) of the first voxel from a to b that is not known to be free; (1, length) if all is.")
      .def("changes", &changes, py::arg("min_voxels") = 10,
           "Returns what appeared or disappeared between submaps: dicts with kind, center, box_min, box_max [m, frame "
           "W],\n"
           "voxels and submap.")
      .def("states", &states, py::arg("points_W"), "(n,) int8 states (0 unknown, 1 free, 2 occupied).")
      .def("mesh", &colored_mesh,
           "(vertices (k, 3) float32, triangles (t, 3) uint32, colors (k, 3) uint8) of the believed surface, frame W.")
      .def(
          "save_octomap",
          [](SubmapCollection& c, const std::string& path) { return said_shift(write_octomap(&c, path), path); },
          py::arg("path"),
          "Writes the merged map for OctoMap: .ot (log-odds) or .bt (binary).\n\nReturns what LocalMap.save_octomap() "
          "returns.")
      .def("save_clouds", &submap::save_clouds, py::arg("dir"), py::call_guard<py::gil_scoped_release>(),
           "Writes the surface points of each submap as submap_<id>.ply (frame S), and poses.txt with lines of\n"
           "id end_s x y z qx qy qz qw.")
      .def("save_mesh", &save_mesh, py::arg("path"), "Writes the mesh as binary PLY, coloured by height.");
}

void bind_files(py::class_<SubmapCollection>& cls) {
  cls.def("save", &SubmapCollection::save, py::arg("dir"), py::call_guard<py::gil_scoped_release>(),
          "Saves the map with a version and checksums. A crash during a save leaves the map that was saved before.")
      .def_static(
          "load", &load, py::arg("dir"), py::arg("recover") = false, py::arg("config") = py::none(),
          "Loads a saved map. Raises with the reason if something is broken; with recover=True it returns (collection\n"
          "of what is intact, list of problems) instead.\n\n"
          "config: SubmapCollectionConfig to use instead of the saved settings.")
      .def_static(
          "load_octomap",
          [](const std::string& path, const SubmapCollectionConfig& config) {
            const py::gil_scoped_release release;
            return submap::load_octomap(path, config);
          },
          py::arg("path"), py::arg("config") = SubmapCollectionConfig{},
          "Makes a map of an OctoMap file (.ot or .bt), whose occupied voxels become surfaces and all others free.\n\n"
          "Raises RuntimeError naming the file if it cannot be read, or has voxels of another size than the config.")
      .def(
          "export",
          [](SubmapCollection& c, const std::string& dir) { return said_shift(export_into(&c, dir), dir + "/map.ot"); },
          py::arg("dir"),
          "Writes mesh.ply, occupied.ply, map.ot, the clouds of the submaps and their poses.\n\n"
          "Returns what save_octomap() returns.");
}

}  // namespace

void bind_submap_collection(py::module_& m) {
  bind_config<SubmapCollectionConfig>(m, "SubmapCollectionConfig", "Parameters of SubmapCollection.");
  py::class_<SubmapCollection> cls(m, "SubmapCollection",
                                   "All submaps and the map merged from them, in which the newest evidence wins.");
  cls.def(py::init<const SubmapCollectionConfig&>(), py::arg("config") = SubmapCollectionConfig{})
      .def("add", &add, py::arg("id"), py::arg("submap"), py::arg("T_W_S"), py::arg("stamp") = 0.0,
           py::arg("bend") = py::none(),
           "Adds a submap, or replaces the one with this id.\n\n"
           "stamp: seconds; a later stamp makes newer evidence, and with equal stamps a higher id does. bend: (2, 4, "
           "4),\n"
           "see submap_bends(); with None the submap is rigid.")
      .def(
          "add_finished", [](SubmapCollection& c, const SubmapEntry& entry) { c.add(entry); }, py::arg("finished"),
          "Adds a FinishedSubmap of a SubmapAssembler, which lies at its T_O_S until set_poses() moves it.")
      .def(
          "set_poses", &set_poses, py::arg("poses"), py::arg("bends") = py::dict(),
          "Moves submaps.\n\n"
          "poses: {id: T_W_S}; bends: {id: (2, 4, 4)}, see submap_bends(); a submap in poses without a bend is rigid.\n"
          "Raises KeyError for an unknown id.")
      .def("bends", &bends, "{id: (2, 4, 4)}, oldest first.")
      .def("poses", &poses, "{id: T_W_S}, oldest first.")
      .def(
          "submap",
          [](const SubmapCollection& c, std::uint32_t id) {
            const SubmapEntry* entry = c.find(id);
            if (!entry) throw py::key_error(std::to_string(id));
            return std::const_pointer_cast<Submap>(entry->submap);
          },
          py::arg("id"))
      .def("remove", &SubmapCollection::remove, py::arg("id"))
      .def("__len__", &SubmapCollection::size)
      .def(
          "merge",
          [](SubmapCollection& c, const SubmapCollection& other, const py::array& T_W_other) {
            return c.merge(other, pose_of(T_W_other, "T_W_other"));
          },
          py::arg("other"), py::arg("T_W_other"),
          "Takes over the submaps of another flight; returns the number that was added to their ids.")
      .def_property_readonly("memory_bytes", &SubmapCollection::memory_bytes)
      .def_property_readonly("num_resident", &SubmapCollection::num_resident, "Submaps in memory; others are on disk.");
  bind_files(cls);
  bind_queries(cls);
  bind_obstacles(m);
}

}  // namespace voxnav::bindings
