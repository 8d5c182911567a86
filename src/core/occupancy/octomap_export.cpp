// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/octomap_export.hpp"

#include <octomap/octomap.h>

#include <cmath>
#include <fstream>
#include <memory>
#include <sstream>
#include <stdexcept>

namespace voxnav::occupancy {
namespace {

octomap::OcTree octree_of(const LocalMap& map) {
  octomap::OcTree tree(map.config().resolution_m);
  tree.setClampingThresMin(map.config().prob_clamp_min);
  tree.setClampingThresMax(map.config().prob_clamp_max);
  tree.setProbHit(map.config().prob_hit);
  tree.setProbMiss(map.config().prob_miss);
  tree.setOccupancyThres(map.config().occupied_threshold);
  map.for_known([&](const LocalMap::KnownVoxel& voxel) {
    const geometry::Vec3 center = geometry::center_of(voxel.index, map.config().resolution_m);
    octomap::OcTreeKey key;
    if (!tree.coordToKeyChecked(center.x(), center.y(), center.z(), key)) return;
    tree.setNodeValue(key, static_cast<float>(voxel.log_odds), true);
  });
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

std::unique_ptr<octomap::OcTree> read_octree(const std::string& path) {
  auto tree = std::make_unique<octomap::OcTree>(0.1);
  if (ends_with(path, ".bt")) return tree->readBinary(path) ? std::move(tree) : nullptr;
  std::unique_ptr<octomap::AbstractOcTree> any(octomap::AbstractOcTree::read(path));
  auto* octree = dynamic_cast<octomap::OcTree*>(any.get());
  if (octree != nullptr) any.release();
  return std::unique_ptr<octomap::OcTree>(octree);
}

/// Appends the voxels of one leaf of an OctoMap: a pruned leaf stands for all voxels of its cube.
void append_leaf(const geometry::Vec3& center, double size, double resolution_m, double log_odds,
                 std::vector<LocalMap::VoxelLogOdds>* out) {
  const auto n = static_cast<int>(std::lround(size / resolution_m));
  for (int i = 0; i < n * n * n; ++i) {
    const geometry::Vec3 at(i % n, i / n % n, i / n / n);
    out->push_back({center + (at.array() - 0.5 * (n - 1)).matrix() * resolution_m, log_odds});
  }
}

}  // namespace

LocalMap load_octomap(const std::string& path, LocalMapConfig config, const geometry::Vec3& center) {
  const std::unique_ptr<octomap::OcTree> tree = read_octree(path);
  if (!tree) throw std::runtime_error("cannot read an OcTree from " + path);
  config.resolution_m = tree->getResolution();
  LocalMap map(config);
  map.place_window(center);
  const std::array<int, 3> n = config.window_blocks();
  const geometry::Vec3 half =
      0.5 * geometry::kBlockSide * config.resolution_m * geometry::Vec3(n[0] + 1, n[1] + 1, n[2] + 1);
  const auto corner = [&](double sign) {
    const geometry::Vec3 p = center + sign * half;
    return octomap::point3d(static_cast<float>(p.x()), static_cast<float>(p.y()), static_cast<float>(p.z()));
  };
  std::vector<LocalMap::VoxelLogOdds> voxels;
  for (auto leaf = tree->begin_leafs_bbx(corner(-1.0), corner(1.0)); leaf != tree->end_leafs_bbx(); ++leaf) {
    append_leaf({leaf.getX(), leaf.getY(), leaf.getZ()}, leaf.getSize(), config.resolution_m, leaf->getLogOdds(),
                &voxels);
  }
  map.assign(voxels);
  return map;
}

void save_octomap(const LocalMap& map, const std::string& path) {
  const bool binary = ends_with(path, ".bt");
  if (!binary && !ends_with(path, ".ot")) throw std::invalid_argument("an OctoMap file ends in .ot or .bt: " + path);
  std::ofstream file(path, std::ios::binary);
  if (!file) throw std::runtime_error("cannot write " + path);
  octomap::OcTree tree = octree_of(map);
  const bool written = binary ? tree.writeBinary(file) : tree.write(file);
  file.close();
  if (!written || !file) throw std::runtime_error("cannot write " + path);
}

std::vector<std::int8_t> octomap_message_data(const LocalMap& map, bool binary) {
  octomap::OcTree tree = octree_of(map);
  std::stringstream stream;
  if (binary) {
    tree.toMaxLikelihood();
    tree.writeBinaryData(stream);
  } else {
    tree.writeData(stream);
  }
  const std::string bytes = stream.str();
  return std::vector<std::int8_t>(bytes.begin(), bytes.end());
}

}  // namespace voxnav::occupancy
