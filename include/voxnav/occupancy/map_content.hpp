// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::occupancy {

/// The surface point of an occupied voxel: the quantised mean of the hits in it.
struct VoxelPoint {
  /// Offset from the voxel centre in steps of 1/254 of a voxel edge, so that +-127 is the face of the voxel.
  std::array<std::int8_t, 3> mean{};
  std::uint8_t hits = 0;  ///< scans that hit the voxel, saturates at 255
  friend bool operator==(const VoxelPoint& a, const VoxelPoint& b) { return a.mean == b.mean && a.hits == b.hits; }
};

/// Stands for a time of hits that is not known: the middle between two handovers.
constexpr std::uint8_t kUnknownTime = 128;

/// An occupied voxel with its surface points, as the local map hands it over and as a submap keeps it.
struct OccupiedVoxel {
  std::uint16_t offset = 0;  ///< geometry::offset_in_block()
  VoxelPoint believed;       ///< mean of all hits that the local map remembers
  /// Mean of the hits since the last handover alone: what the submap observed itself. Without hits the voxel is only
  /// remembered. Submaps are registered by observed points, because surfaces that two submaps inherited from the same
  /// local map say nothing about their relative pose.
  VoxelPoint observed;
  std::uint8_t observed_time = kUnknownTime;  ///< mean time of these hits: 0 after the last handover, 255 at this one
};

/// One bit for each voxel of a block, in words of 64 voxels.
using VoxelBits = std::array<std::uint64_t, geometry::kBlockVolume / 64>;

/// The known part of one block of 16^3 voxels.
struct ContentBlock {
  geometry::Index3 index;  ///< block index in the map's grid
  containers::StateBlock states;
  std::vector<OccupiedVoxel> occupied;  ///< sorted by offset; exactly the voxels whose state is occupied
  /// Free voxels that rays crossed since the last handover; the other free voxels are only remembered.
  VoxelBits observed_free{};
};

/// The known content of a local map, in the form in which it is handed over to a submap. Coordinates are those of the
/// local map's grid (frame O); blocks are sorted by index and hold at least one known voxel.
struct MapContent {
  double resolution_m = 0.0;
  std::vector<ContentBlock> blocks;

  /// Merges newer content: its known voxels replace those of this content.
  /// @throws std::invalid_argument if the resolutions differ
  void merge(const MapContent& newer);

  std::size_t num_occupied() const;
  std::size_t memory_bytes() const;

  /// Serialises the content, little-endian, with a version and a checksum.
  std::string to_bytes() const;
  /// @throws std::invalid_argument naming what is wrong with the bytes
  static MapContent from_bytes(const std::string& bytes);
};

/// Returns the believed surface point of an occupied voxel, in the frame of the grid [m].
geometry::Vec3f surface_point(const geometry::Index3& block, const OccupiedVoxel& voxel, double resolution_m);

}  // namespace voxnav::occupancy
