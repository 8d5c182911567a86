// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <functional>
#include <memory>
#include <optional>

#include "voxnav/base/time.hpp"
#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

/// What the simulated vehicle senses of the world around it. A function that is empty is that of flat, bare ground at
/// height 0.
struct SensedWorld {
  /// Returns the height of the ground at x, y in the world, or nothing outside of the world.
  std::function<std::optional<double>(double x, double y)> ground_height;
  /// Returns the distance to the nearest surface at a time, or `max_m` if nothing is closer.
  std::function<double(const Vec3& p_W, double max_m, voxnav::base::StampNs stamp_ns)> clearance;
  /// Returns the range along a unit direction at a time, or nothing if nothing is closer than `max_m`.
  std::function<std::optional<double>(const Vec3& from_W, const Vec3& direction_W, double max_m,
                                      voxnav::base::StampNs stamp_ns)>
      range;
};

/// Returns what is sensed of a scene, which it keeps alive.
SensedWorld sensed_world_of(const std::shared_ptr<const Scene>& scene);

}  // namespace voxnav_simulation
