// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {

/// Writes the known voxels of a local map as a pruned OctoMap. Unknown voxels are left out. Source of the format:
/// Hornung et al., OctoMap, Autonomous Robots 2013, section 4.
///
/// The ending of the path chooses the format: `.ot` (log-odds) or `.bt` (occupied and free).
/// @throws std::invalid_argument for another ending, std::runtime_error if the file cannot be written
void save_octomap(const LocalMap& map, const std::string& path);

/// Reads a local map from an OctoMap file (.ot or .bt), with its window around `center`; voxels outside it are left
/// out. The resolution is that of the file. Voxels keep their log-odds, clamped, and get no hit statistics.
/// @throws std::runtime_error when the file cannot be read as an OcTree, base::ConfigError when the window does not fit
LocalMap load_octomap(const std::string& path, LocalMapConfig config, const geometry::Vec3& center);

/// Returns the data of an octomap_msgs/Octomap with id "OcTree"; `binary` is the field of that message.
std::vector<std::int8_t> octomap_message_data(const LocalMap& map, bool binary);

}  // namespace voxnav::occupancy
