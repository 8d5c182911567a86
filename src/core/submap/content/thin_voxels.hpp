// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "submap/content/block_states.hpp"

namespace voxnav::submap {

/// Returns for every occupied voxel, by its number, whether it is thin: it has so few occupied voxels around it that no
/// surface can go through it, as with wires, poles, thin trunks and single voxels. O(occupied voxels).
std::vector<bool> find_thin(const BlockStates& states);

}  // namespace voxnav::submap
