// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <unordered_map>
#include <vector>

#include "submap/distance/distance_block.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/submap/mesh.hpp"

namespace voxnav::submap {

/// Extracts the zero level of distances at voxel centres as triangles, block by block. The corners of a cube are the
/// centres of 2^3 voxels; vertices lie on its edges and are shared with the cubes around.
/// Source: Lorensen and Cline, Marching Cubes, SIGGRAPH 1987; the polygons are traced along the faces of a cube with
/// inside corners kept apart on ambiguous faces, which makes neighbouring cubes agree without a table of cases.
class MarchingCubes {
 public:
  /// @param T_A_G  pose of the voxel grid in the frame of the mesh
  /// @param mesh   receives the triangles
  MarchingCubes(const geometry::Pose& T_A_G, double resolution_m, Mesh* mesh)
      : T_A_G_(T_A_G), resolution_m_(resolution_m), mesh_(mesh) {}

  /// Adds the cubes whose lowest corners lie in a block, until the mesh has `max_triangles`.
  void add_block(const geometry::Index3& block, const DistanceBlock& distances, std::size_t max_triangles);

 private:
  /// The distances at the corners of a cube, x fastest.
  using Corners = std::array<float, 8>;
  /// An edge of the grid: from the centre of a voxel along an axis.
  struct Edge {
    geometry::Index3 voxel;
    int axis;
    friend bool operator==(const Edge& a, const Edge& b) { return a.voxel == b.voxel && a.axis == b.axis; }
  };
  struct EdgeHash {
    std::size_t operator()(const Edge& e) const {
      return geometry::Index3Hash{}(e.voxel) * 3 + static_cast<std::size_t>(e.axis);
    }
  };
  void add_cube(const geometry::Index3& lower, const Corners& values);
  std::uint32_t vertex(const geometry::Index3& lower, int edge, const Corners& values);

  geometry::Pose T_A_G_;
  double resolution_m_;
  Mesh* mesh_;
  std::vector<std::uint32_t> polygon_;
  std::unordered_map<Edge, std::uint32_t, EdgeHash> vertices_;
};

}  // namespace voxnav::submap
