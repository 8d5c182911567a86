// SPDX-License-Identifier: BSD-3-Clause
#include "submap/mesh/marching_cubes.hpp"

namespace voxnav::submap {
namespace {

using geometry::Index3;

/// Corners of each face of a cube, counter-clockwise seen from outside; corner bits are x, y, z.
constexpr int kFaces[6][4] = {{0, 4, 6, 2}, {1, 3, 7, 5}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 2, 3, 1}, {4, 5, 7, 6}};

/// Returns the number of an edge of the cube, 3 * lower corner + axis.
int edge_of(int a, int b) {
  const int axis = (a ^ b) == 1 ? 0 : (a ^ b) == 2 ? 1 : 2;
  return 3 * (a & b) + axis;
}

constexpr int kNoEdge = -1;
using NextEdge = std::array<int, 24>;

/// Computes, for every edge that the zero level crosses, the edge that follows it around its polygon.
NextEdge trace_faces(const std::array<bool, 8>& is_inside) {
  NextEdge next;
  next.fill(kNoEdge);
  for (const auto& face : kFaces) {
    int into[4];  // edges crossed on the way in, and their place around the face
    int out_of[4];
    for (int i = 0; i < 4; ++i) {
      const int a = face[i];
      const int b = face[(i + 1) % 4];
      out_of[i] = is_inside[a] && !is_inside[b] ? edge_of(a, b) : kNoEdge;
      into[i] = !is_inside[a] && is_inside[b] ? edge_of(a, b) : kNoEdge;
    }
    for (int i = 0; i < 4; ++i) {
      if (out_of[i] == kNoEdge) continue;
      // The polygon continues at the crossing before this one, as its line cuts off the inside corners between the two.
      for (int back = 1; back < 4; ++back) {
        const int edge = into[(i + 4 - back) % 4];
        if (edge == kNoEdge) continue;
        next[edge] = out_of[i];
        break;
      }
    }
  }
  return next;
}

}  // namespace

void MarchingCubes::add_block(const Index3& block, const DistanceBlock& distances, std::size_t max_triangles) {
  Corners values;
  for (int offset = 0; offset < geometry::kBlockVolume && mesh_->triangles.size() < max_triangles; ++offset) {
    const Index3 local = geometry::voxel_at({0, 0, 0}, offset);
    if (distances.corners(local.x, local.y, local.z, &values)) add_cube(geometry::voxel_at(block, offset), values);
  }
}

void MarchingCubes::add_cube(const Index3& lower, const Corners& values) {
  std::array<bool, 8> is_inside;
  int num_inside = 0;
  for (int i = 0; i < 8; ++i) num_inside += is_inside[i] = values[i] < 0.f;
  if (num_inside == 0 || num_inside == 8) return;
  NextEdge next = trace_faces(is_inside);
  for (int start = 0; start < 24; ++start) {
    if (next[start] == kNoEdge) continue;
    polygon_.clear();
    for (int edge = start; next[edge] != kNoEdge;) {
      polygon_.push_back(vertex(lower, edge, values));
      const int following = next[edge];
      next[edge] = kNoEdge;
      edge = following;
    }
    for (std::size_t i = 2; i < polygon_.size(); ++i) {
      mesh_->triangles.push_back({polygon_[0], polygon_[i - 1], polygon_[i]});
    }
  }
}

std::uint32_t MarchingCubes::vertex(const Index3& lower, int edge, const Corners& values) {
  const int corner = edge / 3;
  const int axis = edge % 3;
  const Index3 voxel = lower + Index3{corner & 1, (corner >> 1) & 1, corner >> 2};
  const auto inserted = vertices_.try_emplace({voxel, axis}, static_cast<std::uint32_t>(mesh_->vertices.size()));
  if (inserted.second) {
    const float a = values[static_cast<std::size_t>(corner)];
    const float b = values[static_cast<std::size_t>(corner | (1 << axis))];
    geometry::Vec3 p(voxel.x + 0.5, voxel.y + 0.5, voxel.z + 0.5);
    p[axis] += a / (a - b);
    mesh_->vertices.emplace_back((T_A_G_ * (p * resolution_m_)).cast<float>());
  }
  return inserted.first->second;
}

}  // namespace voxnav::submap
