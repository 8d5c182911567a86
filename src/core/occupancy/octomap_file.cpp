// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/octomap_file.hpp"

#include <algorithm>
#include <fstream>
#include <iomanip>
#include <stdexcept>

#include "voxnav/occupancy/octomap_export.hpp"

namespace voxnav::occupancy {
namespace {

constexpr const char* kShiftComment = "# shift_voxels ";
constexpr const char* kShiftMeaning = " (of voxnav: to be added to voxels of this file, times res to coordinates)";

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

void VoxelBounds::add(const geometry::Index3& voxel) {
  if (is_empty) low = high = voxel;
  is_empty = false;
  low = {std::min(low.x, voxel.x), std::min(low.y, voxel.y), std::min(low.z, voxel.z)};
  high = {std::max(high.x, voxel.x), std::max(high.y, voxel.y), std::max(high.z, voxel.z)};
}

bool is_octomap_path(const std::string& path) { return ends_with(path, ".bt") || ends_with(path, ".ot"); }

OctomapForm octomap_form_of(const std::string& path) {
  if (ends_with(path, ".bt")) return OctomapForm::kBinary;
  if (ends_with(path, ".ot")) return OctomapForm::kFull;
  throw std::invalid_argument("an OctoMap file ends in .ot or .bt: " + path);
}

std::optional<geometry::Vec3> shift_m(const OctomapNodes& nodes, double resolution_m) {
  if (nodes.shift == geometry::Index3{}) return std::nullopt;
  return geometry::Vec3(nodes.shift.x, nodes.shift.y, nodes.shift.z) * resolution_m;
}

void write_octomap(const OctomapNodes& nodes, OctomapForm form, double resolution_m, const std::string& path) {
  std::ofstream file(path, std::ios::binary);
  file << (form == OctomapForm::kBinary ? "# Octomap OcTree binary file\n" : "# Octomap OcTree file\n");
  if (nodes.shift != geometry::Index3{}) {
    file << kShiftComment << nodes.shift.x << ' ' << nodes.shift.y << ' ' << nodes.shift.z << kShiftMeaning << '\n';
  }
  // Fifteen digits restore a resolution such as 0.4 exactly, and do not show its last bit.
  file << "id OcTree\nsize " << nodes.num_nodes << "\nres " << std::setprecision(15) << resolution_m << "\ndata\n"
       << nodes.bytes;
  if (!file.flush()) throw std::runtime_error(path + ": cannot be written");
}

}  // namespace voxnav::occupancy
