// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/safety_area.hpp"

#include <algorithm>

namespace voxnav_simulation {

std::vector<std::string> SafetyAreaConfig::problems() const {
  std::vector<std::string> out;
  if (points_m.size() < 6 || points_m.size() % 2 != 0) out.emplace_back("points_m: x y of at least three corners");
  if (!(min_z_m < max_z_m)) out.emplace_back("min_z_m must be below max_z_m");
  return out;
}

/// Counts the edges that a ray along x crosses. Source: Shimrat 1962, Algorithm 112: position of point relative to
/// polygon, with the correction of Hacker 1962.
bool is_inside(const SafetyAreaConfig& area, const Vec3& p) {
  if (!area.is_enabled) return true;
  if (p.z() < area.min_z_m || p.z() > area.max_z_m) return false;
  const std::vector<double>& corners = area.points_m;
  const std::size_t count = corners.size() / 2;
  bool inside = false;
  for (std::size_t i = 0, j = count - 1; i < count; j = i++) {
    const double xi = corners[2 * i], yi = corners[2 * i + 1], xj = corners[2 * j], yj = corners[2 * j + 1];
    if ((yi > p.y()) != (yj > p.y()) && p.x() < (xj - xi) * (p.y() - yi) / (yj - yi) + xi) inside = !inside;
  }
  return inside;
}

SafetyVerdict keep_inside(const SafetyAreaConfig& area, TrackedTrajectory* trajectory) {
  SafetyVerdict out;
  auto& points = trajectory->points;
  const auto outside = std::find_if(points.begin(), points.end(),
                                    [&](const HeadedPoint& point) { return !is_inside(area, point.position); });
  if (outside == points.end()) return out;
  if (outside == points.begin()) {
    const bool is_any_inside = std::any_of(points.begin(), points.end(),
                                           [&](const HeadedPoint& point) { return is_inside(area, point.position); });
    out.refusal = is_any_inside ? "the trajectory starts outside of the safety area!"
                                : "the whole trajectory is outside of the safety area!";
    return out;
  }
  points.erase(outside, points.end());
  out.is_modified = true;
  return out;
}

}  // namespace voxnav_simulation
