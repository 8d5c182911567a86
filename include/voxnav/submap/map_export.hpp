// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {

/// Writes the known voxels of the merged map as a pruned OctoMap: `.ot` (log-odds) or `.bt` (occupied and free) by the
/// ending of the path. Source of the format: Hornung et al., OctoMap, Autonomous Robots 2013, section 4.
/// @throws std::invalid_argument for another ending, std::runtime_error if the file cannot be written
void save_octomap(const EvidenceMap& evidence, const std::string& path);

/// Writes the surface points of each submap in its own frame as `submap_<id>.ply`, and their poses in `poses.txt`: one
/// line `id end_stamp_s x y z qx qy qz qw` (T_W_S) for each submap, oldest first. The directory must exist.
/// @throws std::runtime_error naming the file that cannot be written
void save_clouds(const SubmapCollection& collection, const std::string& directory);

/// Exports the map for other programs to a directory, which is created if needed: `mesh.ply`, `occupied.ply` (believed
/// surface points), `map.ot`, and the files of save_clouds(). @throws std::runtime_error naming the file
void export_all(SubmapCollection* collection, const std::string& directory);

}  // namespace voxnav::submap
