// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <stdexcept>

#include "occupancy/octomap_file.hpp"
#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {
namespace {

using containers::VoxelState;
using geometry::Index3;

constexpr int kTileBlocks = 12;              // blocks along the horizontal edges of a submap, 77 m with voxels of 0.4 m
constexpr std::size_t kMostBlocks = 200000;  // 800 million voxels; more is no map of a flight
// An OctoMap does not tell how many scans hit a voxel. So many are assumed that the voxel is shown and believed.
constexpr std::uint8_t kAssumedHits = 3;
constexpr double kSameResolution_m = 1e-6;

using StateBlocks = std::map<Index3, containers::StateBlock>;

std::int32_t block_at(std::int64_t voxel) { return static_cast<std::int32_t>(voxel >> geometry::kBlockShift); }

/// Writes the part of a leaf that lies in one block.
void fill(const occupancy::OctomapLeaf& leaf, const Index3& block, VoxelState state, containers::StateBlock* states) {
  const std::int64_t first[3] = {std::int64_t{block.x} * geometry::kBlockSide,
                                 std::int64_t{block.y} * geometry::kBlockSide,
                                 std::int64_t{block.z} * geometry::kBlockSide};
  int from[3], to[3];
  for (int k = 0; k < 3; ++k) {
    from[k] = static_cast<int>(std::max<std::int64_t>(leaf.low[k] - first[k], 0));
    to[k] = static_cast<int>(std::min<std::int64_t>(leaf.low[k] + leaf.side - first[k], geometry::kBlockSide));
  }
  for (int z = from[2]; z < to[2]; ++z) {
    for (int y = from[1]; y < to[1]; ++y) {
      for (int x = from[0]; x < to[0]; ++x) states->set(geometry::offset_in_block({x, y, z}), state);
    }
  }
}

void add(const occupancy::OctomapLeaf& leaf, StateBlocks* blocks) {
  // OctoMap itself calls a voxel occupied from a probability of one half on.
  const VoxelState state = leaf.log_odds >= 0.0f ? VoxelState::kOccupied : VoxelState::kFree;
  Index3 low{block_at(leaf.low[0]), block_at(leaf.low[1]), block_at(leaf.low[2])};
  const std::int64_t last = leaf.side - 1;
  const Index3 high{block_at(leaf.low[0] + last), block_at(leaf.low[1] + last), block_at(leaf.low[2] + last)};
  const std::int64_t side = std::max<std::int64_t>(1, leaf.side >> geometry::kBlockShift);
  if (static_cast<std::size_t>(side * side * side) + blocks->size() > kMostBlocks) {
    throw std::runtime_error("it knows more than " + std::to_string(kMostBlocks) + " blocks of 16^3 voxels");
  }
  for (std::int32_t z = low.z; z <= high.z; ++z) {
    for (std::int32_t y = low.y; y <= high.y; ++y) {
      for (std::int32_t x = low.x; x <= high.x; ++x) fill(leaf, {x, y, z}, state, &(*blocks)[{x, y, z}]);
    }
  }
}

occupancy::ContentBlock content_of(const Index3& index, const containers::StateBlock& states) {
  occupancy::ContentBlock out;
  out.index = index;
  out.states = states;
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const VoxelState state = states.get(offset);
    if (state == VoxelState::kFree) out.observed_free[offset >> 6] |= std::uint64_t{1} << (offset & 63);
    if (state != VoxelState::kOccupied) continue;
    occupancy::OccupiedVoxel voxel;
    voxel.offset = static_cast<std::uint16_t>(offset);
    voxel.believed.hits = voxel.observed.hits = kAssumedHits;  // at the middle of the voxel
    out.occupied.push_back(voxel);
  }
  return out;
}

std::int32_t tile_at(std::int32_t block) {
  return block >= 0 ? block / kTileBlocks : (block - kTileBlocks + 1) / kTileBlocks;
}

/// Divides the blocks into contents of submaps, as a flight would have made them.
std::map<Index3, occupancy::MapContent> tiles_of(const StateBlocks& blocks, double resolution_m) {
  std::map<Index3, occupancy::MapContent> out;
  for (const auto& [index, states] : blocks) {
    occupancy::MapContent& content = out[{tile_at(index.x), tile_at(index.y), 0}];
    content.resolution_m = resolution_m;
    content.blocks.push_back(content_of(index, states));
  }
  return out;
}

void check_resolution(double found_m, double wanted_m) {
  if (std::abs(found_m - wanted_m) <= kSameResolution_m) return;
  throw std::runtime_error("it has voxels of " + std::to_string(found_m) + " m, and this map has voxels of " +
                           std::to_string(wanted_m) + " m");
}

StateBlocks blocks_of(const occupancy::OctomapFile& file) {
  StateBlocks out;
  for (const occupancy::OctomapLeaf& leaf : file.leaves) {
    if (!std::isfinite(leaf.log_odds)) throw std::runtime_error("it has log-odds that are not finite");
    add(leaf, &out);
  }
  return out;
}

}  // namespace

SubmapCollection load_octomap(const std::string& path, const SubmapCollectionConfig& config,
                              const SubmapConfig& submap_config) {
  const occupancy::OctomapFile file = occupancy::read_octomap(path);
  SubmapCollection out(config);
  try {
    check_resolution(file.resolution_m, config.resolution_m);
    for (const auto& [tile, content] : tiles_of(blocks_of(file), config.resolution_m)) {
      const double side_m = kTileBlocks * geometry::kBlockSide * config.resolution_m;
      SubmapEntry entry;
      entry.id = static_cast<std::uint32_t>(out.size());
      entry.T_O_S = entry.T_W_S = geometry::from_position_yaw(side_m * geometry::Vec3(tile.x, tile.y, 0.0), 0.0);
      entry.submap = Submap::from_content(content, entry.T_O_S.inverse(), submap_config);
      out.add(std::move(entry));
    }
  } catch (const std::runtime_error& error) {
    throw std::runtime_error(path + ": " + error.what());
  }
  return out;
}

}  // namespace voxnav::submap
