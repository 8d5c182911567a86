// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/octomap_export.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <stdexcept>

#include "occupancy/local_map_impl.hpp"
#include "occupancy/octomap_file.hpp"

namespace voxnav::occupancy {
namespace {

/// The code of each log-odds level of the map: the level itself in the full form, its state in the binary one.
std::array<std::uint8_t, 256> codes_of_levels(const OctreeForest& forest, OctomapForm form) {
  std::array<std::uint8_t, 256> out;
  for (int level = 0; level < 256; ++level) {
    const containers::VoxelState state = forest.levels.of(level);
    const bool is_known = state != containers::VoxelState::kUnknown && level <= forest.scale.max;
    const bool is_occupied = state == containers::VoxelState::kOccupied;
    const std::uint8_t code =
        form == OctomapForm::kFull ? static_cast<std::uint8_t>(level) : (is_occupied ? kOccupiedVoxel : kFreeVoxel);
    out[level] = is_known ? code : kNoVoxel;
  }
  return out;
}

OctomapNodes nodes_of(const LocalMap& map, OctomapForm form) {
  const OctreeForest& forest = map.impl().forest;
  OctomapSource source;
  forest.for_blocks([&](const geometry::Index3& index, const OctreeBlock& block) {
    if (block.has_known()) source.blocks.push_back(index);
  });
  const std::array<std::uint8_t, 256> codes = codes_of_levels(forest, form);
  source.read = [&](const geometry::Index3& index, VoxelCodes* out) {
    const OctreeBlock& block = *forest.window.find(index);
    std::transform(block.log_odds.begin(), block.log_odds.end(), out->begin(),
                   [&](std::uint8_t level) { return codes[level]; });
  };
  for (int level = 0; level < 256; ++level) source.log_odds.push_back(static_cast<float>(forest.scale.log_odds(level)));
  return octomap_nodes(source, form);
}

/// Voxels on their way into a map. They go there in portions, since one pruned leaf can stand for billions.
class Assignment {
 public:
  explicit Assignment(LocalMap* map) : map_(map) {}

  void add(const geometry::Index3& voxel, double log_odds) {
    voxels_.push_back({geometry::center_of(voxel, map_->config().resolution_m), log_odds});
    if (voxels_.size() >= kPortion) flush();
  }
  void flush() {
    num_set_ += map_->assign(voxels_);
    voxels_.clear();
  }
  std::uint64_t num_set() const { return num_set_; }

 private:
  static constexpr std::size_t kPortion = 1 << 16;
  LocalMap* map_;
  std::vector<LocalMap::VoxelLogOdds> voxels_;
  std::uint64_t num_set_ = 0;
};

std::uint64_t volume_of(const OctomapLeaf& leaf) {
  return static_cast<std::uint64_t>(leaf.side) * leaf.side * leaf.side;
}

/// Visits only those voxels of a leaf that are within the bounds.
void assign(const OctomapLeaf& leaf, const VoxelBounds& bounds, Assignment* out) {
  const std::int32_t min[3] = {bounds.low.x, bounds.low.y, bounds.low.z};
  const std::int32_t max[3] = {bounds.high.x, bounds.high.y, bounds.high.z};
  std::int64_t from[3], to[3];
  for (int k = 0; k < 3; ++k) {
    from[k] = std::max<std::int64_t>(leaf.low[k], min[k]);
    to[k] = std::min<std::int64_t>(leaf.low[k] + leaf.side - 1, max[k]);
  }
  for (std::int64_t z = from[2]; z <= to[2]; ++z) {
    for (std::int64_t y = from[1]; y <= to[1]; ++y) {
      for (std::int64_t x = from[0]; x <= to[0]; ++x) {
        out->add({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)},
                 leaf.log_odds);
      }
    }
  }
}

/// A little more than the window: the map itself leaves out what is outside.
VoxelBounds bounds_around(const LocalMap& map, const geometry::Vec3& center) {
  const std::array<int, 3> n = map.config().window_blocks();
  const geometry::Index3 middle = geometry::index_of(center, map.config().resolution_m);
  const geometry::Index3 half{(n[0] / 2 + 1) * geometry::kBlockSide, (n[1] / 2 + 1) * geometry::kBlockSide,
                              (n[2] / 2 + 1) * geometry::kBlockSide};
  VoxelBounds bounds;
  bounds.add(middle - half);
  bounds.add(middle + half);
  return bounds;
}

}  // namespace

LocalMap load_octomap(const std::string& path, LocalMapConfig config, const geometry::Vec3& center,
                      OctomapCounts* counts) {
  const OctomapFile file = read_octomap(path);
  config.resolution_m = file.resolution_m;
  LocalMap map(config);
  constexpr double kReach = 1 << 30;  // voxels, half of what an index holds
  if (!center.allFinite() || center.cwiseAbs().maxCoeff() > kReach * config.resolution_m) {
    throw std::invalid_argument("the centre of the window is not finite or too far from the origin");
  }
  map.place_window(center);
  const VoxelBounds bounds = bounds_around(map, center);
  OctomapCounts found;
  Assignment assignment(&map);
  for (const OctomapLeaf& leaf : file.leaves) {
    found.in_file += volume_of(leaf);
    if (std::isfinite(leaf.log_odds)) {
      assign(leaf, bounds, &assignment);
    } else {
      found.not_finite += volume_of(leaf);
    }
  }
  assignment.flush();
  found.outside_window = found.in_file - found.not_finite - assignment.num_set();
  if (counts != nullptr) *counts = found;
  return map;
}

std::optional<geometry::Vec3> save_octomap(const LocalMap& map, const std::string& path) {
  const OctomapForm form = octomap_form_of(path);
  const OctomapNodes nodes = nodes_of(map, form);
  const double resolution_m = map.config().resolution_m;
  write_octomap(nodes, form, resolution_m, path);
  return shift_m(nodes, resolution_m);
}

std::vector<std::int8_t> octomap_message_data(const LocalMap& map, bool binary) {
  return message_bytes(nodes_of(map, binary ? OctomapForm::kBinary : OctomapForm::kFull));
}

}  // namespace voxnav::occupancy
