// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "voxnav/geometry/distance_field.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// What a submap is registered by: distances to what it observed itself, without what its local map remembered, since
/// two submaps that inherited the same memory fit each other wherever odometry put them. Observed only within the band
/// around its surfaces. The submap itself where its distances were measured by rays, which remember nothing.
/// Frozen; thread-safe. O(size of the submap).
/// @param T_S_B  where the sensor was during the submap, by rising stamps: with it, things that are seen from one side
/// (trunks, branches) lie where their middles are; without, where they were hit
std::shared_ptr<const geometry::DistanceField> registration_field(const std::shared_ptr<const Submap>& submap,
                                                                  const std::vector<geometry::StampedPose>& T_S_B = {});

}  // namespace voxnav::submap
