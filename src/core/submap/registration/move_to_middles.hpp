// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "submap/content/submap_content.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::submap {

/// Trunks, branches and foliage are hit on the side that they are seen from, which changes while one flies past them:
/// registered as they were hit, they go along a little. Moves the surface points that lie in no plane away from where
/// they were seen from, by what the middle of such a thing is behind its hits, within their voxels.
/// @param content  of an observed_content(), which knows when each point was seen
/// @param resolution_m  edge of its voxels
/// @param T_G_B  where the sensor was, by rising stamps, from the submap's beginning to its end; at least one
/// O(surface points).
void move_to_middles(double resolution_m, const std::vector<geometry::StampedPose>& T_G_B, SubmapContent* content);

}  // namespace voxnav::submap
