// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "submap/content/submap_content.hpp"
#include "voxnav/occupancy/map_content.hpp"

namespace voxnav::submap {

/// Packs the content that a local map handed over. O(blocks + occupied voxels).
/// @param distances  distances that were measured by rays: signed distance of every voxel of each block [voxel edges],
///                   x fastest, NaN where none was measured; empty if distances follow from the surface points
/// @throws std::invalid_argument if occupied voxels and states of the content do not match
SubmapContent make_content(const occupancy::MapContent& content, double band,
                           const std::vector<std::vector<float>>* distances = nullptr);

}  // namespace voxnav::submap
