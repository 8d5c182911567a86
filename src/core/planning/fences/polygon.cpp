// SPDX-License-Identifier: BSD-3-Clause
#include "planning/fences/polygon.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace voxnav::planning {
namespace {

double cross(const Vec2& a, const Vec2& b) { return a.x() * b.y() - a.y() * b.x(); }

double distance_to_segment(const Vec2& point, const Vec2& a, const Vec2& b) {
  const Vec2 along = b - a;
  const double squared = along.squaredNorm();
  const double t = squared > 0.0 ? std::min(1.0, std::max(0.0, (point - a).dot(along) / squared)) : 0.0;
  return (point - a - t * along).norm();
}

/// Returns whether a segment touches a solid rectangle, by the axes on which their shadows may be apart.
bool touches(const Rectangle& rectangle, const Vec2& a, const Vec2& b) {
  if ((a.cwiseMin(b).array() > rectangle.max.array()).any()) return false;
  if ((a.cwiseMax(b).array() < rectangle.min.array()).any()) return false;
  const Vec2 half = 0.5 * (rectangle.max - rectangle.min), center = 0.5 * (rectangle.max + rectangle.min);
  const Vec2 along = b - a;
  return std::abs(cross(along, center - a)) <= half.x() * std::abs(along.y()) + half.y() * std::abs(along.x());
}

/// The sign of the turn from a over b to c.
int turn(const Vec2& a, const Vec2& b, const Vec2& c) {
  const double area = cross(b - a, c - a);
  return (area > 0.0) - (area < 0.0);
}

bool is_on(const Vec2& a, const Vec2& b, const Vec2& point) {
  return turn(a, b, point) == 0 && (point.array() >= a.cwiseMin(b).array()).all() &&
         (point.array() <= a.cwiseMax(b).array()).all();
}

bool meet(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  if (turn(a, b, c) * turn(a, b, d) < 0 && turn(c, d, a) * turn(c, d, b) < 0) return true;
  return is_on(a, b, c) || is_on(a, b, d) || is_on(c, d, a) || is_on(c, d, b);
}

}  // namespace

bool is_inside(const Outline& outline, const Vec2& point) {
  bool out = false;
  for_each_edge(outline, [&](const Vec2& a, const Vec2& b) {
    if ((a.y() > point.y()) == (b.y() > point.y())) return;
    const double x = a.x() + (point.y() - a.y()) / (b.y() - a.y()) * (b.x() - a.x());
    if (x > point.x()) out = !out;
  });
  return out;
}

double distance_to_edges(const Outline& outline, const Vec2& point) {
  double least = std::numeric_limits<double>::infinity();
  for_each_edge(outline,
                [&](const Vec2& a, const Vec2& b) { least = std::min(least, distance_to_segment(point, a, b)); });
  return least;
}

double distance(const Rectangle& rectangle, const Vec2& a, const Vec2& b) {
  if (touches(rectangle, a, b)) return 0.0;
  // Apart from each other, one of the two nearest points is a corner of the rectangle or an end of the segment.
  double least = std::numeric_limits<double>::infinity();
  for (const Vec2& end : {a, b}) {
    least = std::min(least, (end - end.cwiseMax(rectangle.min).cwiseMin(rectangle.max)).norm());
  }
  for (const double x : {rectangle.min.x(), rectangle.max.x()}) {
    for (const double y : {rectangle.min.y(), rectangle.max.y()}) {
      least = std::min(least, distance_to_segment(Vec2(x, y), a, b));
    }
  }
  return least;
}

std::optional<double> crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d) {
  const Vec2 along = b - a, other = d - c;
  const double area = cross(along, other);
  if (area == 0.0) return std::nullopt;
  const double t = cross(c - a, other) / area, u = cross(c - a, along) / area;
  if (t < 0.0 || t > 1.0 || u < 0.0 || u > 1.0) return std::nullopt;
  return t;
}

bool is_simple(const Outline& outline) {
  const std::size_t n = outline.size();
  const auto corner = [&](std::size_t i) -> const Vec2& { return outline[i % n]; };
  for (std::size_t i = 0; i < n; ++i) {
    // Neighbours have a corner in common, and nothing else.
    if (corner(i) == corner(i + 1) || is_on(corner(i), corner(i + 1), corner(i + 2)) ||
        is_on(corner(i + 1), corner(i + 2), corner(i))) {
      return false;
    }
    for (std::size_t k = i + 2; k < n; ++k) {
      if (i == 0 && k == n - 1) continue;
      if (meet(corner(i), corner(i + 1), corner(k), corner(k + 1))) return false;
    }
  }
  return true;
}

}  // namespace voxnav::planning
