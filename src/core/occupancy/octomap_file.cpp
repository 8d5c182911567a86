// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/octomap_file.hpp"

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <sstream>
#include <stdexcept>

namespace voxnav::occupancy {
namespace {

constexpr std::int64_t kReach = 1 << 15;  // voxels on each side of the origin that an OctoMap addresses
constexpr const char* kShiftComment = "# shift_voxels ";
constexpr const char* kShiftMeaning = " (of voxnav: to be added to voxels of this file, times res to coordinates)";

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

/// Zero unless the axis reaches beyond an OctoMap; then the middle of what is known, at the corner of a block.
std::int32_t shift_of(std::int64_t low, std::int64_t high, char axis) {
  if (low >= -kReach && high < kReach) return 0;
  const std::int64_t middle = (low + high) / 2 / geometry::kBlockSide * geometry::kBlockSide;
  if (low - middle < -kReach || high - middle >= kReach) {
    throw std::length_error("the map is " + std::to_string(high - low + 1) + " voxels wide along " + axis +
                            ", and an OctoMap holds " + std::to_string(2 * kReach));
  }
  return static_cast<std::int32_t>(middle);
}

octomap::key_type key_of(std::int32_t voxel, std::int32_t shift) {
  return static_cast<octomap::key_type>(voxel - shift + kReach);
}

/// The header is text and ends with the line `data`.
geometry::Index3 shift_in_header(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  geometry::Index3 shift;
  const std::string comment = kShiftComment;
  for (std::string line; std::getline(file, line) && line.rfind("data", 0) != 0;) {
    if (line.rfind(comment, 0) != 0) continue;
    std::istringstream numbers(line.substr(comment.size()));
    if (!(numbers >> shift.x >> shift.y >> shift.z)) throw std::runtime_error(path + ": bad shift in its header");
  }
  return shift;
}

}  // namespace

void VoxelBounds::add(const geometry::Index3& voxel) {
  if (is_empty) low = high = voxel;
  is_empty = false;
  low = {std::min(low.x, voxel.x), std::min(low.y, voxel.y), std::min(low.z, voxel.z)};
  high = {std::max(high.x, voxel.x), std::max(high.y, voxel.y), std::max(high.z, voxel.z)};
}

OctomapWriter::OctomapWriter(double resolution_m, const VoxelBounds& bounds)
    : shift_{shift_of(bounds.low.x, bounds.high.x, 'x'), shift_of(bounds.low.y, bounds.high.y, 'y'),
             shift_of(bounds.low.z, bounds.high.z, 'z')},
      tree_(resolution_m) {}

std::optional<geometry::Vec3> OctomapWriter::shift_m() const {
  if (shift_ == geometry::Index3{}) return std::nullopt;
  return geometry::Vec3(shift_.x, shift_.y, shift_.z) * tree_.getResolution();
}

void OctomapWriter::set(const geometry::Index3& voxel, double log_odds) {
  const octomap::OcTreeKey key(key_of(voxel.x, shift_.x), key_of(voxel.y, shift_.y), key_of(voxel.z, shift_.z));
  tree_.setNodeValue(key, static_cast<float>(log_odds), true);
}

void OctomapWriter::finish() {
  tree_.updateInnerOccupancy();
  tree_.prune();
}

void OctomapWriter::write(const std::string& path) {
  const bool is_binary = ends_with(path, ".bt");
  if (!is_binary && !ends_with(path, ".ot")) {
    throw std::invalid_argument("an OctoMap file ends in .ot or .bt: " + path);
  }
  std::ofstream file(path, std::ios::binary);
  const auto write_tree = [&](std::ostream& out) { return is_binary ? tree_.writeBinary(out) : tree_.write(out); };
  bool is_written = static_cast<bool>(file);
  if (is_written && shift_m()) {
    std::stringstream bytes;
    is_written = write_tree(bytes);
    std::string first_line;
    std::getline(bytes, first_line);
    file << first_line << '\n'
         << kShiftComment << shift_.x << ' ' << shift_.y << ' ' << shift_.z << kShiftMeaning << '\n'
         << bytes.rdbuf();
  } else if (is_written) {
    is_written = write_tree(file);
  }
  if (!is_written || !file.flush()) throw std::runtime_error(path + ": cannot be written");
}

OctomapFile read_octomap(const std::string& path) {
  OctomapFile out;
  if (ends_with(path, ".bt")) {
    out.tree = std::make_unique<octomap::OcTree>(0.1);
    if (!out.tree->readBinary(path)) out.tree.reset();
  } else {
    std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(path));
    if (dynamic_cast<octomap::OcTree*>(any.get())) out.tree.reset(static_cast<octomap::OcTree*>(any.release()));
  }
  if (!out.tree) throw std::runtime_error("cannot read an OcTree from " + path);
  out.shift = shift_in_header(path);
  return out;
}

}  // namespace voxnav::occupancy
