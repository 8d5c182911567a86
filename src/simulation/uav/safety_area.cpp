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

namespace {

using Corner = Eigen::Vector2d;

Corner corner(const SafetyAreaConfig& area, std::size_t i) {
  const std::size_t at = 2 * (i % (area.points_m.size() / 2));
  return {area.points_m[at], area.points_m[at + 1]};
}

/// On which side of a line a point is: positive on the left, negative on the right.
double side(const Corner& from, const Corner& to, const Corner& p) {
  const Corner along = to - from, away = p - from;
  return along.x() * away.y() - along.y() * away.x();
}

}  // namespace

bool is_inside(const SafetyAreaConfig& area, const Vec3& p) {
  return is_inside(area, p, SafetyLimits::kBorderAndHeights);
}

/// Counts the edges that a ray along x crosses. Source: Shimrat 1962, Algorithm 112: position of point relative to
/// polygon, with the correction of Hacker 1962.
bool is_inside(const SafetyAreaConfig& area, const Vec3& p, SafetyLimits limits) {
  if (!area.is_enabled) return true;
  const bool is_level = p.z() >= area.min_z_m && p.z() <= area.max_z_m;
  if (limits == SafetyLimits::kBorderAndHeights && !is_level) return false;
  const std::size_t count = area.points_m.size() / 2;
  bool inside = false;
  for (std::size_t i = 0; i < count; ++i) {
    const Corner a = corner(area, i), b = corner(area, i + count - 1);
    const bool is_beside = (a.y() > p.y()) != (b.y() > p.y());
    if (is_beside && p.x() < (b.x() - a.x()) * (p.y() - a.y()) / (b.y() - a.y()) + a.x()) inside = !inside;
  }
  return inside;
}

bool is_way_inside(const SafetyAreaConfig& area, const Vec3& from, const Vec3& to, SafetyLimits limits) {
  if (!area.is_enabled) return true;
  if (!is_inside(area, from, limits) || !is_inside(area, to, limits)) return false;
  const Corner start = from.head<2>(), end = to.head<2>();
  for (std::size_t i = 0; i < area.points_m.size() / 2; ++i) {
    const Corner a = corner(area, i), b = corner(area, i + 1);
    const bool is_crossed = side(a, b, start) * side(a, b, end) < 0 && side(start, end, a) * side(start, end, b) < 0;
    if (is_crossed) return false;
  }
  return true;
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
