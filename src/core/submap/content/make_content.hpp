// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/content/submap_content.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::submap {

/// What a local map handed over, packed. O(blocks + occupied voxels).
/// @param distances  signed distance of every voxel of each block [voxel edges], x fastest, NaN where none was
/// measured, as rays left them; nothing where distances follow from the surface points
/// @throws std::invalid_argument when occupied voxels and states of the content do not match
SubmapContent make_content(const occupancy::MapContent& content, double band,
                           const std::vector<std::vector<float>>* distances = nullptr);

}  // namespace voxnav::submap
