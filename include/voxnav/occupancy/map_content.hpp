// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::occupancy {

/// Where the surface goes through an occupied voxel: the mean of the hits in it, quantised.
struct VoxelPoint {
  /// From the voxel centre in steps of 1/254 of a voxel edge, so that +-127 is the face of the voxel.
  std::array<std::int8_t, 3> mean{};
  std::uint8_t hits = 0;  ///< scans that hit the voxel, saturates at 255
  friend bool operator==(const VoxelPoint& a, const VoxelPoint& b) { return a.mean == b.mean && a.hits == b.hits; }
};

/// Of a time of hits that is not known: the middle between two handovers.
constexpr std::uint8_t kUnknownTime = 128;

/// One occupied voxel on its way from the local map into a submap, and as the submap keeps it.
struct OccupiedVoxel {
  std::uint16_t offset = 0;  ///< geometry::offset_in_block()
  VoxelPoint believed;       ///< of all hits that the local map remembers
  /// Of the hits since the last handover alone: what the submap observed itself. No hits: it is only remembered.
  /// Submaps are registered by these points, because what two of them inherited says nothing about where they lie.
  VoxelPoint observed;
  std::uint8_t observed_time = kUnknownTime;  ///< mean time of these hits: 0 after the last handover, 255 at this one
};

/// One bit per voxel of a block, in words of 64 voxels.
using VoxelBits = std::array<std::uint64_t, geometry::kBlockVolume / 64>;

/// The known part of one block of 16^3 voxels.
struct ContentBlock {
  geometry::Index3 index;  ///< block index in the map's grid
  containers::StateBlock states;
  std::vector<OccupiedVoxel> occupied;  ///< sorted by offset; exactly the voxels whose state is occupied
  /// Free voxels that rays crossed since the last handover; other free ones are only remembered.
  VoxelBits observed_free{};
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

/// The point that is believed of an occupied voxel, in the frame of the grid [m].
geometry::Vec3f surface_point(const geometry::Index3& block, const OccupiedVoxel& voxel, double resolution_m);

}  // namespace voxnav::occupancy
