// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {

/// Returns true if the ending of a path is that of an OctoMap: `.ot` (log-odds) or `.bt` (occupied and free).
bool is_octomap_path(const std::string& path);

/// Writes the known voxels of a local map as a pruned OctoMap. Unknown voxels are left out. Source of the format:
/// Hornung et al., OctoMap, Autonomous Robots 2013.
///
/// The ending of the path chooses the format: `.ot` (log-odds) or `.bt` (occupied and free). An OctoMap reaches 2^15
/// voxels from its origin: a map that lies farther off is shifted by whole voxels. The shift stands in the header of
/// the file, where load_octomap() finds it.
/// @return  what must be added to coordinates in the file to get those of the map; none where they are the same
/// @throws std::invalid_argument for another ending, std::runtime_error when the file cannot be written,
///         std::length_error for a map that is wider than an OctoMap
std::optional<geometry::Vec3> save_octomap(const LocalMap& map, const std::string& path);

/// What became of the voxels of an OctoMap file. A pruned leaf counts as the cube of voxels that it stands for.
struct OctomapCounts {
  std::uint64_t in_file = 0;
  std::uint64_t outside_window = 0;  ///< left out
  std::uint64_t not_finite = 0;      ///< left out: no log-odds
};

/// Reads a local map from an OctoMap file (.ot or .bt), with its window around `center`; voxels outside it are left
/// out and counted. The resolution is that of the file. Voxels keep their log-odds, clamped, and get no hit
/// statistics. O(leaves of the file + known voxels of the window).
/// @param counts  may be null
/// @throws std::runtime_error when the file cannot be read as an OcTree, base::ConfigError when the window does not
///         fit, std::invalid_argument for a centre that is not finite or beyond the reach of voxel indices
LocalMap load_octomap(const std::string& path, LocalMapConfig config, const geometry::Vec3& center,
                      OctomapCounts* counts = nullptr);

/// Returns the data of an octomap_msgs/Octomap with id "OcTree"; `binary` is the field of that message.
/// @throws std::length_error for a map beyond the reach of an OctoMap, since a message cannot state a shift
std::vector<std::int8_t> octomap_message_data(const LocalMap& map, bool binary);

}  // namespace voxnav::occupancy
