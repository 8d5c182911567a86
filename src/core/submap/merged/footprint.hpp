// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/geometry/bend.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// What of a submap counts: what it observed itself, or also what its local map remembered of submaps before it. The
/// latter lies where odometry put it, which no correction of this submap's pose puts right.
enum class Knowledge { kObserved, kAll };

/// Where a submap lies in W. What it observed itself is bent; memory has no time and stays where the middle is.
struct Placement {
  geometry::Pose T_W_S = geometry::Pose::Identity();
  geometry::Bend bend = {};
};

/// Poses between which everything of the submap lies.
std::vector<geometry::Pose> extremes(const Placement& placement);

/// Blocks of W that the known part of a submap touches, what counts of it; sorted.
std::vector<geometry::Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                                        Knowledge knowledge);

}  // namespace voxnav::submap
