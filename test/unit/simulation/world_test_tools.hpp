// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>

#include "voxnav_simulation/scene.hpp"

namespace voxnav_simulation {

/// Returns a world of level ground at height 0 with nothing on it.
inline WorldConfig empty_world() {
  WorldConfig config;
  config.min_corner_m = {-30.0, -30.0};
  config.size_m = {60.0, 60.0};
  config.goal_m = {20.0, 0.0};
  config.terrain_margin_m = 200.0;
  config.terrain_cell_m = 10.0;
  config.terrain_amplitude_m = 0.0;
  config.terrain_roughness_m = 0.0;
  config.trees_per_ha = config.bushes_per_ha = config.rocks_per_ha = 0.0;
  config.num_poles = config.num_walls = config.num_houses = 0;
  return config;
}

/// Returns a world with few objects of every kind, which is small enough for brute force.
inline WorldConfig small_world() {
  WorldConfig config;
  config.min_corner_m = {-15.0, -15.0};
  config.size_m = {30.0, 30.0};
  config.goal_m = {10.0, 0.0};
  config.clear_radius_m = 2.0;
  config.terrain_margin_m = 2.0;
  config.trees_per_ha = 200.0;
  config.leaves_per_tree = 40;
  config.leaves_per_bush = 20;
  config.num_walls = 1;
  config.num_houses = 0;
  config.has_vehicle = true;
  config.vehicle_position_m = {-8.0, 0.0};
  return config;
}

/// Returns the range along a unit direction to a triangle, or nothing if the ray misses it.
/// Source: Möller and Trumbore, Fast, minimum storage ray/triangle intersection, Journal of Graphics Tools 1997.
inline std::optional<double> ray_triangle(const Vec3& origin, const Vec3& d, const Vec3& a, const Vec3& b,
                                          const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, p = d.cross(ac);
  const double det = ab.dot(p);
  if (std::abs(det) < 1e-14) return std::nullopt;
  const Vec3 t = origin - a;
  const double u = t.dot(p) / det;
  const Vec3 q = t.cross(ab);
  const double v = d.dot(q) / det, range = ac.dot(q) / det;
  if (u < 0 || v < 0 || u + v > 1 || range < 0) return std::nullopt;
  return range;
}

inline double distance_to_segment(const Vec3& p, const Vec3& a, const Vec3& b) {
  const double t = std::min(1.0, std::max(0.0, (p - a).dot(b - a) / (b - a).squaredNorm()));
  return (p - a - t * (b - a)).norm();
}

/// Returns the distance from a point to a triangle by projection onto its plane or else to its nearest edge, which is
/// another method than that of the code under test.
inline double slow_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  double best = std::min({distance_to_segment(p, a, b), distance_to_segment(p, b, c), distance_to_segment(p, c, a)});
  const Vec3 normal = (b - a).cross(c - a).normalized();
  for (const double side : {-1.0, 1.0}) {
    const auto range = ray_triangle(p, side * normal, a, b, c);
    if (range) best = std::min(best, *range);
  }
  return best;
}

/// Returns all triangles of a scene, with the vehicle at its present pose.
inline WorldMesh all_of(const Scene& scene) {
  WorldMesh mesh = scene.world().mesh();
  if (const auto pose = scene.vehicle_pose()) append_mesh(&mesh, scene.world().vehicle_mesh(), *pose);
  return mesh;
}

inline Vec3 corner(const WorldMesh& mesh, std::size_t triangle, int i) {
  return mesh.vertices[mesh.triangles[triangle][i]].cast<double>();
}

inline Hit cast_one(const Scene& scene, const Vec3& origin, const Vec3& direction, double max_m) {
  Hit hit;
  const Vec3f d = direction.normalized().cast<float>();
  scene.cast(origin.cast<float>(), &d, 1, static_cast<float>(max_m), &hit);
  return hit;
}

}  // namespace voxnav_simulation
