// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <vector>

#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

/// What a corridor may hold.
enum class CorridorRule {
  kKnownFreeOnly,  ///< flight: unknown is as bad as occupied
  kNotOccupied     ///< planning: only occupied voxels count
};

struct CorridorResult {
  bool is_safe = true;
  double first_unsafe_m = 0.0;        ///< arc length at which the corridor first touches an unsafe voxel; if unsafe
  State unsafe_state = State::kFree;  ///< of that voxel; if unsafe
  geometry::Vec3 unsafe_point = geometry::Vec3::Zero();  ///< centre of that voxel; if unsafe
  double length_m = 0.0;                                 ///< of the whole polyline
};

/// Checks the space swept by a ball of `radius_m` along a polyline: exact against the boxes of all voxels that the
/// ball touches, in three dimensions. One point is a ball. Points that are not finite, or none, are unsafe at 0.
/// O(length * radius^2 / resolution^3); stops at the first unsafe piece.
CorridorResult check_corridor(const OccupancyView& view, const std::vector<geometry::Vec3>& points, double radius_m,
                              CorridorRule rule = CorridorRule::kKnownFreeOnly);

}  // namespace voxnav::planning
