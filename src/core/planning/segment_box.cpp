// SPDX-License-Identifier: BSD-3-Clause
#include "planning/segment_box.hpp"

#include <algorithm>

namespace voxnav::planning {
namespace {

constexpr int kBisections = 48;

/// Returns the vector from the nearest point of the box to the point.
geometry::Vec3 excess(const geometry::Vec3& point, const geometry::Aabb& box) {
  return point - point.cwiseMax(box.min).cwiseMin(box.max);
}

}  // namespace

double squared_distance(const geometry::Vec3& point, const geometry::Aabb& box) {
  return excess(point, box).squaredNorm();
}

double nearest_parameter(const Segment& segment, const geometry::Aabb& box) {
  const geometry::Vec3 direction = segment.b - segment.a;
  const auto slope = [&](double t) { return excess(segment.at(t), box).dot(direction); };
  if (slope(0.0) >= 0.0) return 0.0;
  if (slope(1.0) < 0.0) return 1.0;
  double low = 0.0, high = 1.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (slope(middle) < 0.0 ? low : high) = middle;
  }
  return high;
}

double squared_distance(const Segment& segment, const geometry::Aabb& box) {
  return squared_distance(segment.at(nearest_parameter(segment, box)), box);
}

double first_parameter_within(const Segment& segment, const geometry::Aabb& box, double distance) {
  const double limit = distance * distance;
  if (squared_distance(segment.a, box) < limit) return 0.0;
  double high = nearest_parameter(segment, box);
  if (squared_distance(segment.at(high), box) >= limit) return -1.0;
  double low = 0.0;
  for (int i = 0; i < kBisections; ++i) {
    const double middle = 0.5 * (low + high);
    (squared_distance(segment.at(middle), box) < limit ? high : low) = middle;
  }
  return low;
}

}  // namespace voxnav::planning
