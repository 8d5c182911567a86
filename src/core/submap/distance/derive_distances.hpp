// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "submap/content/submap_content.hpp"
#include "submap/distance/distance_block.hpp"

namespace voxnav::submap {

/// Derives the distances near the surfaces of one block from the surface points and the states alone: of free voxels
/// (kernels::measure_free()), of occupied ones (occupied_distance()) and of unknown ones beside them
/// (UnknownDistances). Outside of things they are exact up to rounding of floats, inside of them the error is at most
/// half a voxel edge. The result depends on nothing but the content, so a block may be dropped and derived again.
/// Distances that were measured by rays are copied instead.
/// @param block  index of the block, which may be empty itself
/// @return null if there is no distance in the block
/// @complexity O(surface points around * band^3)
std::shared_ptr<const DistanceBlock> derive_distances(const SubmapContent& content, const geometry::Index3& block);

}  // namespace voxnav::submap
