// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>
#include <random>
#include <vector>

#include "voxnav/geometry/pose.hpp"

/// A scan of 128 x 1024 points of an analytic forest, which has ground and trunks.
namespace voxnav::benchmark {

struct Trunk {
  double x, y, radius;
};

inline std::vector<Trunk> trunks() {
  std::mt19937 rng(7);
  std::uniform_real_distribution<double> place(-40.0, 40.0);
  std::uniform_real_distribution<double> radius(0.05, 0.4);
  std::vector<Trunk> out;
  while (out.size() < 190) {
    const Trunk trunk{place(rng), place(rng), radius(rng)};
    if (std::hypot(trunk.x, trunk.y) > 2.0) out.push_back(trunk);
  }
  return out;
}

/// Returns the range along a unit direction from 2 m above the ground, or 0 if nothing is within 60 m.
inline double range_of(const geometry::Vec3& direction, const std::vector<Trunk>& forest) {
  double range = direction.z() < 0.0 ? -2.0 / direction.z() : 1e9;
  const double a = direction.x() * direction.x() + direction.y() * direction.y();
  for (const Trunk& t : forest) {
    const double b = direction.x() * t.x + direction.y() * t.y;
    const double discriminant = b * b - a * (t.x * t.x + t.y * t.y - t.radius * t.radius);
    if (b <= 0.0 || discriminant < 0.0) continue;
    const double hit = (b - std::sqrt(discriminant)) / a;
    if (2.0 + hit * direction.z() < 12.0) range = std::min(range, hit);
  }
  return range < 60.0 ? range : 0.0;
}

/// Returns x, y, z of each return in frame L.
inline const std::vector<float>& scan() {
  static const std::vector<float> points = [] {
    std::vector<float> out;
    const std::vector<Trunk> forest = trunks();
    for (int column = 0; column < 1024; ++column) {
      for (int row = 0; row < 128; ++row) {
        const double azimuth = column * (2.0 * M_PI / 1024.0);
        const double elevation = (45.0 - row * (90.0 / 127.0)) * M_PI / 180.0;
        const geometry::Vec3 direction(std::cos(azimuth) * std::cos(elevation), std::sin(azimuth) * std::cos(elevation),
                                       std::sin(elevation));
        const double range = range_of(direction, forest);
        if (range <= 0.0) continue;
        for (int axis = 0; axis < 3; ++axis) out.push_back(static_cast<float>(direction[axis] * range));
      }
    }
    return out;
  }();
  return points;
}

/// Returns the positions of a slow flight, so that the map is neither empty nor always the same.
inline geometry::Vec3 position(std::int64_t i) { return {0.1 * static_cast<double>(i % 50), 0.0, 2.0}; }

}  // namespace voxnav::benchmark
