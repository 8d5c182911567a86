// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav/planning/fences.hpp"
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

/// Which voxels a corridor may contain.
enum class CorridorRule {
  kKnownFreeOnly,  ///< only free voxels are safe: the rule for what is flown
  kNotOccupied     ///< free and unknown voxels are safe: the rule for what is only planned
};

struct CorridorResult {
  bool is_safe = true;
  double first_unsafe_m =
      0.0;  ///< if unsafe: arc length at which the corridor first touches an unsafe voxel or a fence
  VoxelState unsafe_state = VoxelState::kFree;           ///< if unsafe: state of that voxel, or of the one at the fence
  geometry::Vec3 unsafe_point = geometry::Vec3::Zero();  ///< if unsafe: centre of that voxel, or where the fence is met
  std::optional<FenceContact> fence;                     ///< if unsafe because of a fence: which one
  double length_m = 0.0;                                 ///< length of the whole polyline
};

/// Checks the space that a ball of `radius_m` sweeps along a polyline, exactly against the cubes of all voxels that the
/// ball touches, and against the fences of the view: the ball may touch no zone by either rule, and its centre stays in
/// the area by kKnownFreeOnly. A single point is checked as one ball. A polyline without points, or with a point that
/// is not finite, is unsafe at arc length 0. O(length * radius^2 / resolution^3); the check stops at the first unsafe
/// segment.
CorridorResult check_corridor(const OccupancyView& view, const std::vector<geometry::Vec3>& points, double radius_m,
                              CorridorRule rule = CorridorRule::kKnownFreeOnly);

/// Tells in a few words what is unsafe about a corridor: "occupied", "unknown", or which kind of fence it meets.
const char* what_is_unsafe(const CorridorResult& corridor);

}  // namespace voxnav::planning
