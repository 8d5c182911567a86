// SPDX-License-Identifier: BSD-3-Clause
#include <octomap/octomap.h>

#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "submap/files/map_files.hpp"
#include "voxnav/submap/mesh.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {
namespace {

constexpr float kLogOdds = 2.0f;  // a little within the clamping bounds of OctoMap

void add_block(const geometry::Index3& index, const ColumnBlock& states, double resolution_m, octomap::OcTree* tree) {
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const containers::VoxelState state = states.get(offset);
    if (state == containers::VoxelState::kUnknown) continue;
    const geometry::Vec3 center = geometry::center_of(geometry::voxel_at(index, offset), resolution_m);
    octomap::OcTreeKey key;
    if (!tree->coordToKeyChecked(center.x(), center.y(), center.z(), key)) continue;
    tree->setNodeValue(key, state == containers::VoxelState::kOccupied ? kLogOdds : -kLogOdds, true);
  }
}

void write_file(const std::string& path, const std::string& bytes) {
  std::ofstream out(path, std::ios::binary);
  out.write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
  if (!out.flush()) throw std::runtime_error(path + ": cannot be written");
}

std::string pose_line(const SubmapEntry& entry) {
  const Eigen::Quaterniond q(entry.T_W_S.linear());
  const geometry::Vec3 t = entry.T_W_S.translation();
  char line[256];
  std::snprintf(line, sizeof(line), "%u %.9f %.6f %.6f %.6f %.9f %.9f %.9f %.9f\n", entry.id,
                base::to_seconds(entry.end_ns), t.x(), t.y(), t.z(), q.x(), q.y(), q.z(), q.w());
  return line;
}

}  // namespace

void save_octomap(const EvidenceMap& evidence, const std::string& path) {
  const std::string ending = path.size() < 3 ? "" : path.substr(path.size() - 3);
  if (ending != ".bt" && ending != ".ot") throw std::invalid_argument("an OctoMap file ends in .ot or .bt: " + path);
  octomap::OcTree tree(evidence.resolution_m());
  for (const auto& item : evidence.blocks()) add_block(item.first, item.second.states, evidence.resolution_m(), &tree);
  tree.updateInnerOccupancy();
  tree.prune();
  std::ofstream file(path, std::ios::binary);
  const bool is_written = file && (ending == ".bt" ? tree.writeBinary(file) : tree.write(file));
  if (!is_written || !file.flush()) throw std::runtime_error(path + ": cannot be written");
}

void save_clouds(const SubmapCollection& collection, const std::string& directory) {
  std::string poses;
  for (const SubmapEntry* entry : collection.entries()) {
    char name[32];
    std::snprintf(name, sizeof(name), "/submap_%06u.ply", entry->id);
    Mesh cloud;
    cloud.vertices = entry->submap->occupied_points();
    write_file(directory + name, to_ply(cloud));
    poses += pose_line(*entry);
  }
  write_file(directory + "/poses.txt", poses);
}

void export_all(SubmapCollection* collection, const std::string& directory) {
  make_directory(directory);
  write_file(directory + "/mesh.ply", to_ply(extract_mesh(collection)));
  Mesh points;
  points.vertices = collection->occupied_points();
  write_file(directory + "/occupied.ply", to_ply(points));
  save_octomap(collection->evidence(), directory + "/map.ot");
  save_clouds(*collection, directory);
}

}  // namespace voxnav::submap
