// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/geometry/pose.hpp"
#include "voxnav_simulation/materials.hpp"

namespace voxnav_simulation {

using voxnav::geometry::Pose;
using voxnav::geometry::Vec3;
using voxnav::geometry::Vec3f;

/// A triangle mesh with a class for each triangle.
struct WorldMesh {
  std::vector<Vec3f> vertices;
  std::vector<std::array<std::uint32_t, 3>> triangles;
  std::vector<SurfaceClass> classes;  ///< one per triangle

  std::uint32_t add_vertex(const Vec3& p);
  void add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, SurfaceClass surface_class);
};

/// A straight round rod from a to b whose radius changes linearly.
struct Rod {
  Vec3 a;
  Vec3 b;
  double radius_a_m;
  double radius_b_m;
};

/// Appends a rod as a prism with `num_sides` sides, closed at both ends, whose cross-section has the area of the rod's.
void append_rod(WorldMesh* mesh, const Rod& rod, int num_sides, SurfaceClass surface_class);

/// Appends a box of the given edge lengths, centred at T_W_box.
void append_box(WorldMesh* mesh, const Pose& T_W_box, const Vec3& size_m, SurfaceClass surface_class);

/// Appends a single triangle with corners at center + a, center + b and center - a - b, which stands for a leaf.
void append_leaf(WorldMesh* mesh, const Vec3& center, const Vec3& a, const Vec3& b);

/// Appends a rock: an ellipsoid of 80 triangles whose 42 corners are moved outwards by the factors `bulge`.
void append_rock(WorldMesh* mesh, const Vec3& center, const Vec3& radii_m, const std::array<double, 42>& bulge);

/// Appends all triangles of `part`, transformed by T_W_part.
void append_mesh(WorldMesh* mesh, const WorldMesh& part, const Pose& T_W_part);

/// Returns the shortest distance from a point to a triangle.
/// Source: Ericson, Real-Time Collision Detection, 2005, section 5.1.5.
double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c);

/// Writes a binary PLY file with vertices, faces with class and colour, and a `comment` line for each of `comments`.
/// @throws std::runtime_error when the file cannot be written
void save_ply(const WorldMesh& mesh, const std::vector<std::string>& comments, const std::string& path);

}  // namespace voxnav_simulation
