// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>
#include <map>

#include "voxnav_simulation/mesh.hpp"

namespace voxnav_simulation {
namespace {

using Face = std::array<std::uint32_t, 3>;

struct Sphere {
  std::vector<Vec3> corners;
  std::vector<Face> faces;
};

Sphere icosahedron() {
  const double g = (1.0 + std::sqrt(5.0)) / 2.0;
  Sphere out;
  for (const double a : {-1.0, 1.0}) {
    for (const double b : {-g, g}) {
      for (const Vec3& p : {Vec3(a, b, 0), Vec3(0, a, b), Vec3(b, 0, a)}) out.corners.push_back(p.normalized());
    }
  }
  // The faces of an icosahedron are the triples of corners whose distances are one edge length.
  const double edge = (Vec3(-1, g, 0) - Vec3(1, g, 0)).norm() / std::sqrt(1.0 + g * g);
  const auto is_edge = [&](std::uint32_t i, std::uint32_t j) {
    return std::abs((out.corners[i] - out.corners[j]).norm() - edge) < 1e-6;
  };
  for (std::uint32_t i = 0; i < 12; ++i) {
    for (std::uint32_t j = i + 1; j < 12; ++j) {
      for (std::uint32_t k = j + 1; k < 12; ++k) {
        if (is_edge(i, j) && is_edge(j, k) && is_edge(i, k)) out.faces.push_back({i, j, k});
      }
    }
  }
  return out;
}

/// Splits each face into four, and moves the new corners out onto the sphere.
Sphere subdivided(const Sphere& in) {
  Sphere out{in.corners, {}};
  std::map<std::pair<std::uint32_t, std::uint32_t>, std::uint32_t> middles;
  const auto middle = [&](std::uint32_t i, std::uint32_t j) {
    const auto [it, is_new] = middles.try_emplace(std::minmax(i, j), static_cast<std::uint32_t>(out.corners.size()));
    if (is_new) out.corners.push_back((in.corners[i] + in.corners[j]).normalized());
    return it->second;
  };
  for (const Face& f : in.faces) {
    const std::uint32_t ab = middle(f[0], f[1]), bc = middle(f[1], f[2]), ca = middle(f[2], f[0]);
    out.faces.insert(out.faces.end(), {{f[0], ab, ca}, {f[1], bc, ab}, {f[2], ca, bc}, {ab, bc, ca}});
  }
  return out;
}

}  // namespace

void append_rock(WorldMesh* mesh, const Vec3& center, const Vec3& radii_m, const std::array<double, 42>& bulge) {
  static const Sphere kSphere = subdivided(icosahedron());
  const auto first = static_cast<std::uint32_t>(mesh->vertices.size());
  for (std::size_t i = 0; i < bulge.size(); ++i) {
    mesh->add_vertex(center + bulge[i] * kSphere.corners[i].cwiseProduct(radii_m));
  }
  for (const Face& f : kSphere.faces) mesh->add_triangle(first + f[0], first + f[1], first + f[2], SurfaceClass::kRock);
}

}  // namespace voxnav_simulation
