// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "submap/content/submap_content.hpp"
#include "voxnav/geometry/pose.hpp"

namespace voxnav::submap {

/// Moves the surface points that lie in no plane away from the sensor, to the middle of the thing that was hit, but not
/// out of their voxels. Trunks, branches and foliage are hit on the side from which they are seen, and this side
/// changes while the vehicle flies past: registered by their hits, they would seem to move along with it a little.
/// O(surface points). docs/alignment.md has the measurements.
/// @param resolution_m  edge of the voxels of `content`
/// @param T_G_B         poses of the sensor by rising stamps, from the submap's beginning to its end; at least one
/// @param content       result of observed_content(), in which every point has the time at which it was seen
void move_to_middles(double resolution_m, const std::vector<geometry::StampedPose>& T_G_B, SubmapContent* content);

}  // namespace voxnav::submap
