// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/sensed_world.hpp"

namespace voxnav_simulation {

SensedWorld sensed_world_of(const std::shared_ptr<const Scene>& scene) {
  SensedWorld out;
  out.ground_height = [scene](double x, double y) { return scene->world().ground_height(x, y); };
  out.clearance = [scene](const Vec3& p_W, double max_m, voxnav::base::StampNs stamp_ns) {
    return scene->clearance(p_W, max_m, stamp_ns);
  };
  out.range = [scene](const Vec3& from_W, const Vec3& direction_W, double max_m,
                      voxnav::base::StampNs stamp_ns) -> std::optional<double> {
    const Vec3f direction = direction_W.cast<float>();
    Hit hit;
    scene->cast(from_W.cast<float>(), &direction, 1, static_cast<float>(max_m), &hit, stamp_ns);
    if (!hit.is_hit()) return std::nullopt;
    return static_cast<double>(hit.range_m);
  };
  return out;
}

}  // namespace voxnav_simulation
