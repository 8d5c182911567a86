// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/octomap_export.hpp"

#include <octomap/octomap.h>

#include <fstream>
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
  const StateLevels& levels = map.levels();
  for (int slot = 0; slot < map.window().num_slots(); ++slot) {
    const OctreeBlock* block = map.window().at(slot);
    if (block == nullptr || !block->has_known()) continue;
    const geometry::Index3 index = map.window().block_at(slot);
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const int level = block->log_odds[offset];
      if (levels.of(level) == containers::State::kUnknown) continue;
      const geometry::Vec3 center = geometry::center_of(geometry::voxel_at(index, offset), map.config().resolution_m);
      octomap::OcTreeKey key;
      if (!tree.coordToKeyChecked(center.x(), center.y(), center.z(), key)) continue;
      tree.setNodeValue(key, static_cast<float>(map.scale().log_odds(level)), true);
    }
  }
  tree.updateInnerOccupancy();
  tree.prune();
  return tree;
}

bool ends_with(const std::string& text, const std::string& ending) {
  return text.size() >= ending.size() && text.compare(text.size() - ending.size(), ending.size(), ending) == 0;
}

}  // namespace

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
