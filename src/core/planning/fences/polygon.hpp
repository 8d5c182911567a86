// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace voxnav::planning {

using Vec2 = Eigen::Vector2d;
using Outline = std::vector<Vec2>;

/// An axis-aligned rectangle in the plane.
struct Rectangle {
  Vec2 min;
  Vec2 max;
};

/// Returns whether a point is inside a polygon, by the number of edges to its right. Source: Shimrat, Algorithm 112,
/// Communications of the ACM 1962, with half-open edges.
bool is_inside(const Outline& outline, const Vec2& point);

/// Distance from a point to the nearest edge, from inside as from outside.
double distance_to_edges(const Outline& outline, const Vec2& point);

/// Distance between a rectangle, which is solid, and a segment.
double distance(const Rectangle& rectangle, const Vec2& a, const Vec2& b);

/// Returns the parameter on the segment from `a` to `b` at which it crosses or touches the segment from `c` to `d`;
/// nothing if it does not, or if the two are parallel.
std::optional<double> crossing(const Vec2& a, const Vec2& b, const Vec2& c, const Vec2& d);

/// Returns whether no two edges cross or touch, but for the corners that neighbours have in common. O(corners^2).
bool is_simple(const Outline& outline);

/// Calls fn(a, b) for each edge, the last of which leads back to the first corner.
template <class Fn>
void for_each_edge(const Outline& outline, Fn fn) {
  for (std::size_t i = 0; i < outline.size(); ++i) fn(outline[i], outline[i + 1 == outline.size() ? 0 : i + 1]);
}

}  // namespace voxnav::planning
