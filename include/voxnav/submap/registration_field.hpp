// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// Returns the distance field by which a submap is registered to others. It holds the distances to the surface points
/// that the submap observed, without what its local map remembered: two submaps that inherit the same content fit each
/// other wherever odometry put them. It is defined only within the band around these surfaces. A submap whose distances
/// were measured by rays is its own field, as it remembers nothing. Immutable; thread-safe. O(size of the submap).
/// @param T_S_B  poses of the sensor during the submap, by rising stamps. With them, things that are seen from one side
///               (trunks, branches) are registered by their middles, without them by the side that was hit
std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap,
                                                                  const std::vector<geometry::StampedPose>& T_S_B = {});

}  // namespace voxnav::submap
