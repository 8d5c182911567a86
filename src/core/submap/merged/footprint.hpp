// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/submap.hpp"

namespace voxnav::submap {

/// Which content of a submap is merged: only what it observed, or also what its local map remembered from before the
/// submap. Remembered content lies where odometry put it, and correcting the pose of this submap does not correct it.
enum class Knowledge { kObserved, kAll };

/// The placement of a submap in W. Observed points are moved by the bend according to their time; remembered content
/// has no time and moves with the pose, which is that of the submap's middle.
struct Placement {
  geometry::Pose T_W_S = geometry::Pose::Identity();
  geometry::Bend bend = {};
};

/// Returns the poses between which all content of the submap is placed.
std::vector<geometry::Pose> extremes(const Placement& placement);

/// Returns the blocks of W that the known content of a submap touches, as far as it is merged; sorted.
std::vector<geometry::Index3> footprint(const Submap& submap, const Placement& placement, double resolution_m,
                                        Knowledge knowledge);

}  // namespace voxnav::submap
