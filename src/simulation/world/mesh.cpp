// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav_simulation/mesh.hpp"

#include <algorithm>
#include <cmath>

namespace voxnav_simulation {
namespace {

/// Returns two unit vectors that form a right-handed frame with `axis`.
std::pair<Vec3, Vec3> perpendiculars(const Vec3& axis) {
  const Vec3 helper = std::abs(axis.z()) < 0.9 ? Vec3::UnitZ() : Vec3::UnitX();
  const Vec3 u = axis.cross(helper).normalized();
  return {u, axis.cross(u)};
}

std::uint32_t append_ring(WorldMesh* mesh, const Vec3& center, const Vec3& axis, double radius_m, int num_sides) {
  const auto [u, v] = perpendiculars(axis);
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (int i = 0; i < num_sides; ++i) {
    const double angle = 2.0 * M_PI * i / num_sides;
    mesh->add_vertex(center + radius_m * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return first;
}

}  // namespace

std::uint32_t WorldMesh::add_vertex(const Vec3& p) {
  vertices.emplace_back(p.cast<float>());
  return static_cast<std::uint32_t>(vertices.size() - 1);
}

void WorldMesh::add_triangle(std::uint32_t a, std::uint32_t b, std::uint32_t c, SurfaceClass surface_class) {
  triangles.push_back({a, b, c});
  classes.push_back(surface_class);
}

void append_rod(WorldMesh* mesh, const Rod& rod, int num_sides, SurfaceClass surface_class) {
  const Vec3 axis = (rod.b - rod.a).normalized();
  const double step = 2.0 * M_PI / num_sides;
  const double to_corner = std::sqrt(step / std::sin(step));
  const auto n = static_cast<std::uint32_t>(num_sides);
  const std::uint32_t a = append_ring(mesh, rod.a, axis, rod.radius_a_m * to_corner, num_sides);
  const std::uint32_t b = append_ring(mesh, rod.b, axis, rod.radius_b_m * to_corner, num_sides);
  const std::uint32_t center_a = mesh->add_vertex(rod.a);
  const std::uint32_t center_b = mesh->add_vertex(rod.b);
  for (std::uint32_t i = 0; i < n; ++i) {
    const std::uint32_t j = (i + 1) % n;
    mesh->add_triangle(a + i, a + j, b + j, surface_class);
    mesh->add_triangle(a + i, b + j, b + i, surface_class);
    mesh->add_triangle(center_a, a + j, a + i, surface_class);
    mesh->add_triangle(center_b, b + i, b + j, surface_class);
  }
}

void append_box(WorldMesh* mesh, const Pose& T_W_box, const Vec3& size_m, SurfaceClass surface_class) {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (int i = 0; i < 8; ++i) {
    const Vec3 corner((i & 1) - 0.5, ((i >> 1) & 1) - 0.5, ((i >> 2) & 1) - 0.5);
    mesh->add_vertex(T_W_box * corner.cwiseProduct(size_m));
  }
  constexpr std::array<std::array<std::uint32_t, 4>, 6> kFaces{
      {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}}};
  for (const auto& f : kFaces) {
    mesh->add_triangle(first + f[0], first + f[1], first + f[2], surface_class);
    mesh->add_triangle(first + f[0], first + f[2], first + f[3], surface_class);
  }
}

void append_leaf(WorldMesh* mesh, const Vec3& center, const Vec3& a, const Vec3& b) {
  const std::uint32_t first = mesh->add_vertex(center + a);
  mesh->add_vertex(center + b);
  mesh->add_vertex(center - a - b);
  mesh->add_triangle(first, first + 1, first + 2, SurfaceClass::kFoliage);
}

void append_mesh(WorldMesh* mesh, const WorldMesh& part, const Pose& T_W_part) {
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (const Vec3f& vertex : part.vertices) mesh->add_vertex(T_W_part * vertex.cast<double>());
  for (std::size_t i = 0; i < part.triangles.size(); ++i) {
    const auto& t = part.triangles[i];
    mesh->add_triangle(first + t[0], first + t[1], first + t[2], part.classes[i]);
  }
}

double distance_to_triangle(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.norm();
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.norm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).norm();
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.norm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).norm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0) {
    const double along = (d4 - d3) / ((d4 - d3) + (d5 - d6));
    return (bp - along * (c - b)).norm();
  }
  const double scale = 1.0 / (va + vb + vc);
  return (ap - vb * scale * ab - vc * scale * ac).norm();
}

}  // namespace voxnav_simulation
