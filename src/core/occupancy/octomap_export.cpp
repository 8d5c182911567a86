// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/occupancy/octomap_export.hpp"

#include <octomap/octomap.h>

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

#include "occupancy/octomap_file.hpp"

namespace voxnav::occupancy {
namespace {

OctomapWriter octree_of(const LocalMap& map) {
  VoxelBounds bounds;
  map.for_known([&](const LocalMap::KnownVoxel& voxel) { bounds.add(voxel.index); });
  OctomapWriter writer(map.config().resolution_m, bounds);
  octomap::OcTree& tree = writer.tree();
  tree.setClampingThresMin(map.config().prob_clamp_min);
  tree.setClampingThresMax(map.config().prob_clamp_max);
  tree.setProbHit(map.config().prob_hit);
  tree.setProbMiss(map.config().prob_miss);
  tree.setOccupancyThres(map.config().occupied_threshold);
  map.for_known([&](const LocalMap::KnownVoxel& voxel) { writer.set(voxel.index, voxel.log_odds); });
  writer.finish();
  return writer;
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

/// A leaf is a cube of voxels; only those within the bounds are visited.
struct LeafCube {
  std::int64_t low[3];
  std::int64_t side;

  std::uint64_t volume() const { return static_cast<std::uint64_t>(side) * side * side; }

  void assign(const VoxelBounds& bounds, double log_odds, Assignment* out) const {
    const std::int32_t min[3] = {bounds.low.x, bounds.low.y, bounds.low.z};
    const std::int32_t max[3] = {bounds.high.x, bounds.high.y, bounds.high.z};
    std::int64_t from[3], to[3];
    for (int k = 0; k < 3; ++k) {
      from[k] = std::max<std::int64_t>(low[k], min[k]);
      to[k] = std::min<std::int64_t>(low[k] + side - 1, max[k]);
    }
    for (std::int64_t z = from[2]; z <= to[2]; ++z) {
      for (std::int64_t y = from[1]; y <= to[1]; ++y) {
        for (std::int64_t x = from[0]; x <= to[0]; ++x) {
          out->add({static_cast<std::int32_t>(x), static_cast<std::int32_t>(y), static_cast<std::int32_t>(z)},
                   log_odds);
        }
      }
    }
  }
};

LeafCube cube_of(const octomap::OcTree::leaf_iterator& leaf, const geometry::Index3& shift) {
  constexpr std::int64_t kOrigin = 1 << 15;  // key of the voxel with index 0
  const octomap::OcTreeKey key = leaf.getIndexKey();
  const unsigned depth = leaf.getDepth();
  return {{key[0] - kOrigin + shift.x, key[1] - kOrigin + shift.y, key[2] - kOrigin + shift.z},
          std::int64_t{1} << (16u - depth)};
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
  config.resolution_m = file.tree->getResolution();
  LocalMap map(config);
  constexpr double kReach = 1 << 30;  // voxels, half of what an index holds
  if (!center.allFinite() || center.cwiseAbs().maxCoeff() > kReach * config.resolution_m) {
    throw std::invalid_argument("the centre of the window is not finite or too far from the origin");
  }
  map.place_window(center);
  const VoxelBounds bounds = bounds_around(map, center);
  OctomapCounts found;
  Assignment assignment(&map);
  for (auto leaf = file.tree->begin_leafs(); leaf != file.tree->end_leafs(); ++leaf) {
    const LeafCube cube = cube_of(leaf, file.shift);
    found.in_file += cube.volume();
    if (std::isfinite(leaf->getLogOdds())) {
      cube.assign(bounds, leaf->getLogOdds(), &assignment);
    } else {
      found.not_finite += cube.volume();
    }
  }
  assignment.flush();
  found.outside_window = found.in_file - found.not_finite - assignment.num_set();
  if (counts != nullptr) *counts = found;
  return map;
}

std::optional<geometry::Vec3> save_octomap(const LocalMap& map, const std::string& path) {
  OctomapWriter writer = octree_of(map);
  writer.write(path);
  return writer.shift_m();
}

std::vector<std::int8_t> octomap_message_data(const LocalMap& map, bool binary) {
  OctomapWriter writer = octree_of(map);
  if (writer.shift_m()) {
    throw std::length_error(
        "the map lies farther than 2^15 voxels from the origin of its frame, beyond the reach of an "
        "OctoMap message; use an odometry frame with its origin nearby");
  }
  std::stringstream stream;
  if (binary) {
    writer.tree().toMaxLikelihood();
    writer.tree().writeBinaryData(stream);
  } else {
    writer.tree().writeData(stream);
  }
  const std::string bytes = stream.str();
  return std::vector<std::int8_t>(bytes.begin(), bytes.end());
}

}  // namespace voxnav::occupancy
