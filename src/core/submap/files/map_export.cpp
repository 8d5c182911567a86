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

constexpr float kLogOdds = 2.0f;  // a little within the clamping bounds of OctoMap

/// Calls f(voxel, state) for each known voxel.
template <class F>
void for_known(const EvidenceMap& evidence, const F& f) {
  for (const auto& [index, block] : evidence.blocks()) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const containers::VoxelState state = block.states.get(offset);
      if (state != containers::VoxelState::kUnknown) f(geometry::voxel_at(index, offset), state);
    }
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

std::optional<geometry::Vec3> save_octomap(const EvidenceMap& evidence, const std::string& path) {
  occupancy::VoxelBounds bounds;
  for_known(evidence, [&](const geometry::Index3& voxel, containers::VoxelState) { bounds.add(voxel); });
  occupancy::OctomapWriter writer(evidence.resolution_m(), bounds);
  for_known(evidence, [&](const geometry::Index3& voxel, containers::VoxelState state) {
    writer.set(voxel, state == containers::VoxelState::kOccupied ? kLogOdds : -kLogOdds);
  });
  writer.finish();
  writer.write(path);
  return writer.shift_m();
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
