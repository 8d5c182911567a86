// SPDX-License-Identifier: BSD-3-Clause
#include <cstdio>
#include <fstream>
#include <stdexcept>

#include "occupancy/octomap_file.hpp"
#include "submap/files/map_files.hpp"
#include "voxnav/submap/mesh.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {
namespace {

// Log-odds of free and occupied voxels, a little within the clamping bounds of OctoMap.
constexpr float kFreeLogOdds = -2.0f, kOccupiedLogOdds = 2.0f;

occupancy::OctomapNodes nodes_of(const EvidenceMap& evidence, occupancy::OctomapForm form) {
  occupancy::OctomapSource source;
  source.log_odds = {kFreeLogOdds, kOccupiedLogOdds};
  for (const auto& [index, block] : evidence.blocks()) {
    if (!block.states.all_unknown()) source.blocks.push_back(index);
  }
  source.read = [&](const geometry::Index3& index, occupancy::VoxelCodes* codes) {
    const ColumnBlock& states = evidence.find(index)->states;
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const auto column = static_cast<std::size_t>(offset & 255);
      const int z = offset >> 8;
      const bool is_free = (states.free[column] >> z & 1) != 0;
      const bool is_occupied = (states.occupied[column] >> z & 1) != 0;
      (*codes)[offset] =
          is_occupied ? occupancy::kOccupiedVoxel : (is_free ? occupancy::kFreeVoxel : occupancy::kNoVoxel);
    }
  };
  return octomap_nodes(source, form);
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

std::optional<geometry::Vec3> save_octomap(const EvidenceMap& evidence, const std::string& path) {
  const occupancy::OctomapForm form = occupancy::octomap_form_of(path);
  const occupancy::OctomapNodes nodes = nodes_of(evidence, form);
  write_octomap(nodes, form, evidence.resolution_m(), path);
  return shift_m(nodes, evidence.resolution_m());
}

std::vector<std::int8_t> octomap_message_data(const EvidenceMap& evidence, bool binary) {
  return message_bytes(nodes_of(evidence, binary ? occupancy::OctomapForm::kBinary : occupancy::OctomapForm::kFull));
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

std::optional<geometry::Vec3> export_all(SubmapCollection* collection, const std::string& directory) {
  make_directory(directory);
  write_file(directory + "/mesh.ply", to_ply(extract_mesh(collection)));
  Mesh points;
  points.vertices = collection->occupied_points();
  write_file(directory + "/occupied.ply", to_ply(points));
  save_clouds(*collection, directory);
  return save_octomap(collection->evidence(), directory + "/map.ot");
}

}  // namespace voxnav::submap
