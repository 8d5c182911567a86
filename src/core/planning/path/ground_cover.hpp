// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "planning/clearance/clearance_field_impl.hpp"

namespace voxnav::planning {

/// Tells that a voxel of which nothing is known lies below the ground: nearly all columns around it of which something
/// is known have nothing free at its height or below, and a surface above it. A roof looks the same from above, which
/// is why the surroundings are wider than most roofs.
bool is_below_ground(const ClearanceField::Impl& field, const geometry::Index3& voxel);

}  // namespace voxnav::planning
