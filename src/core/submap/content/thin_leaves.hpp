// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "submap/content/compressed_field.hpp"

namespace voxnav::submap {

/// For every occupied voxel, in the order of the field, whether it has so few occupied voxels around it that no surface
/// can go through it: wires, poles, thin trunks, single voxels. O(leaves).
std::vector<bool> find_thin(const CompressedField& field);

}  // namespace voxnav::submap
