// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>

#include "submap/content/submap_content.hpp"
#include "submap/distance/distance_block.hpp"

namespace voxnav::submap {

/// Distances near the surfaces of one block, from the surface points and states alone: those of free voxels
/// (kernels::measure_free()), of occupied ones (occupied_distance()) and of unknown ones beside them
/// (UnknownDistances). Exact to float rounding; the error inside of things is half an edge at most. A function of the
/// content, so that a block may be forgotten and made again. Distances that were measured by rays are copied instead.
/// @param block  by its index; it need not hold anything itself  @return null when there is no distance in it
/// @complexity O(surface points around * band^3)
std::shared_ptr<const DistanceBlock> derive_distances(const SubmapContent& content, const geometry::Index3& block);

}  // namespace voxnav::submap
