// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

namespace voxnav::occupancy {

/// Known voxels as an OctoMap, pruned. Voxels of unknown state are left out. Source of the format: Hornung et al.,
/// OctoMap, Autonomous Robots 2013.
///
/// Writes `.ot` (log-odds) or `.bt` (occupied and free), by the ending of the path.
/// @throws std::invalid_argument for another ending, std::runtime_error when the file cannot be written
void save_octomap(const LocalMap& map, const std::string& path);

/// A local map of an OctoMap file (.ot or .bt) with its window around `center`; what lies outside is left out. The
/// resolution is that of the file. Voxels keep their log-odds, clamped; nothing is known of hit points inside them.
/// @throws std::runtime_error when the file cannot be read as an OcTree, base::ConfigError when the window does not fit
LocalMap load_octomap(const std::string& path, LocalMapConfig config, const geometry::Vec3& center);

/// Data of an octomap_msgs/Octomap with id "OcTree". `binary` as in that message.
std::vector<std::int8_t> octomap_message_data(const LocalMap& map, bool binary);

}  // namespace voxnav::occupancy
