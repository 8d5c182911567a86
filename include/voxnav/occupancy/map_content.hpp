// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::occupancy {

/// One occupied leaf with what is known of the surface inside it.
struct OccupiedLeaf {
  std::uint16_t offset;  ///< geometry::offset_in_block()
  std::array<std::int8_t, 3>
      mean;           ///< mean hit point from the voxel centre, unit voxel edge / 254 (so +-127 is the face)
  std::uint8_t hits;  ///< scans that hit the voxel, saturates at 255
  // The same of the hits since the last handover: what the submap saw itself. own_hits = 0: only remembered.
  std::array<std::int8_t, 3> own_mean{};
  std::uint8_t own_hits = 0;
  std::uint8_t own_time = 128;  ///< mean time of these hits: 0 right after the last handover, 255 at this one
};

/// One bit per voxel of a block, in words of 64 voxels.
using VoxelBits = std::array<std::uint64_t, geometry::kBlockVolume / 64>;

/// The known part of one block of 16^3 voxels.
struct ContentBlock {
  geometry::Index3 index;  ///< block index in the map's grid
  containers::StateBlock states;
  std::vector<OccupiedLeaf> occupied;  ///< sorted by offset; exactly the voxels whose state is occupied
  /// Free voxels that were looked at since the last handover; other free ones are only remembered.
  VoxelBits own_free{};
};

/// Everything the local map knows, in the form in which it is handed to a submap. Coordinates are
/// those of the local map's grid (frame O); blocks are sorted by index and hold at least one known voxel.
struct MapContent {
  double resolution_m = 0.0;
  std::vector<ContentBlock> blocks;

  /// Blocks of `newer` replace equal voxels of this content wherever `newer` knows them.
  /// @throws std::invalid_argument when the resolutions differ
  void merge(const MapContent& newer);

  std::size_t num_occupied() const;
  std::size_t memory_bytes() const;

  /// Versioned little-endian form with a checksum.
  std::string to_bytes() const;
  /// @throws std::invalid_argument naming what is wrong with the bytes
  static MapContent from_bytes(const std::string& bytes);
};

/// Surface point of an occupied leaf, in the grid's frame.
geometry::Vec3f surface_point(const geometry::Index3& block, const OccupiedLeaf& leaf, double resolution_m);

}  // namespace voxnav::occupancy
