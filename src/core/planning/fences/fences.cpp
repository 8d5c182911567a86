// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/fences.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "planning/fences/polygon.hpp"

namespace voxnav::planning {
namespace {

using geometry::Aabb;
using geometry::Vec3;

/// Segments are followed in steps no shorter than this, and touch a zone this much before it.
constexpr double kTolerance_m = 1e-3;

bool is_finite(const Prism& prism) {
  return std::isfinite(prism.min_z) && std::isfinite(prism.max_z) &&
         std::all_of(prism.outline.begin(), prism.outline.end(), [](const Vec2& p) { return p.allFinite(); });
}

Aabb box_of(const Prism& prism) {
  Aabb out;
  for (const Vec2& p : prism.outline) {
    out.extend({p.x(), p.y(), prism.min_z});
    out.extend({p.x(), p.y(), prism.max_z});
  }
  return out;
}

bool is_within(const Prism& prism, const Vec3& point) {
  return point.z() >= prism.min_z && point.z() <= prism.max_z && is_inside(prism.outline, point.head<2>());
}

/// Distance from a point to a solid prism, 0 inside it.
double distance_to(const Prism& prism, const Vec3& point) {
  const double above = std::max({0.0, prism.min_z - point.z(), point.z() - prism.max_z});
  const Vec2 flat = point.head<2>();
  return std::hypot(above, is_inside(prism.outline, flat) ? 0.0 : distance_to_edges(prism.outline, flat));
}

/// Follows a segment in steps of its distance from the prism, so that nothing is passed over.
/// Source: Hart, Sphere tracing, The Visual Computer 1996, section 2.
std::optional<double> first_near(const Prism& prism, const Vec3& from, const Vec3& to, double radius_m) {
  const double length_m = (to - from).norm();
  for (double at_m = 0.0;;) {
    const double t = length_m > 0.0 ? at_m / length_m : 0.0;
    const double room_m = distance_to(prism, from + t * (to - from)) - radius_m;
    if (room_m <= kTolerance_m) return t;
    if (at_m >= length_m) return std::nullopt;
    at_m = std::min(length_m, at_m + room_m);
  }
}

std::optional<double> first_outside(const Prism& area, const Vec3& from, const Vec3& to) {
  if (!is_within(area, from)) return 0.0;
  std::optional<double> first;
  const auto consider = [&](double t) { first = std::min(t, first.value_or(t)); };
  for_each_edge(area.outline, [&](const Vec2& a, const Vec2& b) {
    const auto t = crossing(from.head<2>(), to.head<2>(), a, b);
    if (t) consider(*t);
  });
  for (const double z : {area.min_z, area.max_z}) {
    if ((from.z() - z) * (to.z() - z) < 0.0) consider((z - from.z()) / (to.z() - from.z()));
  }
  // The crossing of an edge may be lost in rounding where the segment is parallel to it.
  if (!first && !is_within(area, to)) return 1.0;
  return first;
}

}  // namespace

std::string problem_of(const Prism& prism) {
  if (prism.outline.size() < 3) {
    return "an outline needs at least 3 corners, and has " + std::to_string(prism.outline.size());
  }
  if (!is_finite(prism)) return "a number is not finite";
  if (!(prism.min_z < prism.max_z)) return "min_z must be below max_z";
  if (!is_simple(prism.outline)) return "edges of the outline cross or touch each other, or a corner is repeated";
  return "";
}

Fences::Fences(std::optional<Prism> area, std::vector<Prism> zones) : area_(std::move(area)), zones_(std::move(zones)) {
  const auto check = [](const std::string& name, const Prism& prism) {
    const std::string problem = problem_of(prism);
    if (!problem.empty()) throw std::invalid_argument(name + ": " + problem);
  };
  if (area_) check("area", *area_);
  for (std::size_t i = 0; i < zones_.size(); ++i) {
    check("zone " + std::to_string(i), zones_[i]);
    zone_boxes_.push_back(box_of(zones_[i]));
  }
}

std::optional<FenceContact> Fences::contact(const Vec3& point, double radius_m) const {
  if (area_ && !is_within(*area_, point)) return FenceContact{FenceKind::kArea, 0};
  for (std::size_t i = 0; i < zones_.size(); ++i) {
    if (!zone_boxes_[i].padded(radius_m).contains(point)) continue;
    if (distance_to(zones_[i], point) <= radius_m) return FenceContact{FenceKind::kZone, i};
  }
  return std::nullopt;
}

std::optional<FenceTouch> Fences::first_touch(const Vec3& from, const Vec3& to, double radius_m) const {
  std::optional<FenceTouch> out = first_zone_touch(from, to, radius_m);
  if (!area_) return out;
  const auto t = first_outside(*area_, from, to);
  if (t && (!out || *t <= out->t)) out = FenceTouch{*t, {FenceKind::kArea, 0}};
  return out;
}

std::optional<FenceTouch> Fences::first_zone_touch(const Vec3& from, const Vec3& to, double radius_m) const {
  Aabb swept;
  swept.extend(from);
  swept.extend(to);
  swept = swept.padded(radius_m + kTolerance_m);
  std::optional<FenceTouch> out;
  for (std::size_t i = 0; i < zones_.size(); ++i) {
    if (!zone_boxes_[i].intersects(swept)) continue;
    const auto t = first_near(zones_[i], from, to, radius_m);
    if (t && (!out || *t < out->t)) out = FenceTouch{*t, {FenceKind::kZone, i}};
  }
  return out;
}

}  // namespace voxnav::planning
