// SPDX-License-Identifier: BSD-3-Clause
#include "own_body.hpp"

#include <cmath>
#include <limits>

namespace voxnav_simulation {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

double sphere_range(const Vec3& direction, const Vec3& center, double radius) {
  const double along = center.dot(direction);
  const double inside = radius * radius - (center - along * direction).squaredNorm();
  if (inside < 0.0) return kInfinity;
  const double range = along - std::sqrt(inside);
  return range > 0.0 ? range : kInfinity;
}

/// Returns the range to the round side of a capsule, between its two ends; infinite if the beam misses it.
double tube_range(const Vec3& direction, const Vec3& a, const Vec3& b, double radius) {
  const double length = (b - a).norm();
  if (length < 1e-9) return kInfinity;
  const Vec3 axis = (b - a) / length;
  const Vec3 d = direction - direction.dot(axis) * axis, o = -a + a.dot(axis) * axis;
  const double qa = d.squaredNorm(), qb = d.dot(o), qc = o.squaredNorm() - radius * radius;
  const double root = qb * qb - qa * qc;
  if (qa < 1e-12 || root < 0.0) return kInfinity;
  const double range = (-qb - std::sqrt(root)) / qa;
  const double along = (range * direction - a).dot(axis);
  return range > 0.0 && along >= 0.0 && along <= length ? range : kInfinity;
}

}  // namespace

OwnBody::OwnBody(const LidarConfig& config) {
  const Pose T_L_B = config.T_B_L().inverse();
  const std::vector<double>& c = config.body_capsules_m;
  for (std::size_t i = 0; i + 7 <= c.size(); i += 7) {
    capsules_L_.push_back(
        {T_L_B * Vec3(c[i], c[i + 1], c[i + 2]), T_L_B * Vec3(c[i + 3], c[i + 4], c[i + 5]), c[i + 6]});
  }
}

double OwnBody::range_m(const Vec3& direction_L) const {
  double range = kInfinity;
  for (const Capsule& c : capsules_L_) {
    range = std::min({range, tube_range(direction_L, c.a, c.b, c.radius_m), sphere_range(direction_L, c.a, c.radius_m),
                      sphere_range(direction_L, c.b, c.radius_m)});
  }
  return range;
}

}  // namespace voxnav_simulation
