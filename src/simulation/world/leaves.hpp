// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "voxnav_simulation/mesh.hpp"
#include "voxnav_simulation/random.hpp"

namespace voxnav_simulation {

/// Returns a direction that is uniformly distributed on the unit sphere.
inline Vec3 random_direction(Rng* rng) {
  const double z = rng->uniform(-1.0, 1.0), angle = rng->uniform(0.0, 2.0 * M_PI);
  const double r = std::sqrt(1.0 - z * z);
  return {r * std::cos(angle), r * std::sin(angle), z};
}

/// Appends an equilateral leaf of the given edge length in a random orientation.
inline void append_random_leaf(const Vec3& center, double edge_m, Rng* rng, WorldMesh* mesh) {
  const Vec3 normal = random_direction(rng);
  const Vec3 u = normal.cross(random_direction(rng)).normalized();
  if (!u.allFinite()) return;
  const double corner_m = edge_m / std::sqrt(3.0);
  const Vec3 a = corner_m * u;
  append_leaf(mesh, center, a, corner_m * (-0.5 * u + 0.5 * std::sqrt(3.0) * normal.cross(u)));
}

}  // namespace voxnav_simulation
