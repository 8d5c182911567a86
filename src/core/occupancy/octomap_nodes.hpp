// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// What OctoMap keeps of each voxel: all log-odds, or only whether it is occupied or free.
enum class OctomapForm { kFull, kBinary };

/// One byte for each voxel of a block, by geometry::offset_in_block(). Codes rise with the log-odds of the voxel.
using VoxelCodes = std::array<std::uint8_t, geometry::kBlockVolume>;
constexpr std::uint8_t kNoVoxel = 255;  ///< code of a voxel that is left out
constexpr std::uint8_t kFreeVoxel = 0;  ///< codes of the binary form
constexpr std::uint8_t kOccupiedVoxel = 1;

/// A map as blocks of voxels, from which the nodes of an OctoMap are made.
struct OctomapSource {
  std::vector<geometry::Index3> blocks;  ///< each at most once, in any order
  /// Writes the codes of one of these blocks.
  std::function<void(const geometry::Index3& block, VoxelCodes* codes)> read;
  std::vector<float> log_odds;  ///< of each code, for the full form
};

/// The nodes of a pruned OctoMap in the order and form of OctoMap's own files and messages.
struct OctomapNodes {
  std::string bytes;
  std::size_t num_nodes = 0;
  geometry::Index3 shift;  ///< voxels to be added to those of the OctoMap to get those of the map; whole blocks
};

/// Writes the nodes of an OctoMap straight from blocks, which is several times faster than to build an OcTree of
/// voxels. Eight children that are equal leaves become one leaf. A map beyond the 2^15 voxels that an OctoMap reaches
/// from its origin is shifted. O(voxels of the blocks).
/// Source of the format: Hornung et al., OctoMap, Autonomous Robots 2013, section 3.4; octomap 1.9, writeData() and
/// writeBinaryData().
/// @throws std::length_error for a map that is wider than an OctoMap
OctomapNodes octomap_nodes(const OctomapSource& source, OctomapForm form);

/// Returns the nodes as the data of an octomap_msgs/Octomap.
/// @throws std::length_error for a map that was shifted, since a message cannot state a shift
std::vector<std::int8_t> message_bytes(const OctomapNodes& nodes);

}  // namespace voxnav::occupancy
