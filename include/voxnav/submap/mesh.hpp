// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "voxnav/submap/submap_collection.hpp"

namespace voxnav::submap {

using Color = std::array<std::uint8_t, 3>;

struct Mesh {
  std::vector<geometry::Vec3f> vertices;                ///< positions, m
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from free space
  std::vector<Color> colors;                            ///< one for each vertex, or empty

  /// Adds another mesh with its colours.
  void append(const Mesh& other);
};

/// Extracts the zero level of the distances near the surfaces of a submap, frame S. Only cubes whose eight corners all
/// have distances are meshed; these lie within two voxels of occupied ones, so that no surface appears at the edge of
/// the known space. Stops at max_triangles. O(distances near surfaces).
/// Source: Lorensen & Cline, Marching Cubes, SIGGRAPH 1987; here polygons are traced along the faces with inside
/// corners kept apart on ambiguous faces, which makes neighbouring cubes agree without a table of cases.
Mesh extract_mesh(const Submap& submap, std::size_t max_triangles = 10000000);

/// Extracts the zero level of the merged map in W for the cubes of the given blocks, so that only changed blocks have
/// to be meshed again; the meshes of neighbouring blocks meet. Surfaces that newer evidence has removed are not in it,
/// and no surface is in it twice. Coloured by height. Stops at max_triangles. O(surface points of the blocks and around
/// them).
Mesh extract_mesh(const EvidenceMap& evidence, const std::vector<geometry::Index3>& blocks,
                  std::size_t max_triangles = 10000000);

/// Brings the merged map up to date and extracts its whole mesh.
Mesh extract_mesh(SubmapCollection* collection, std::size_t max_triangles = 10000000);

/// Returns the colour of an id; the colours of neighbouring ids differ clearly.
Color color_of(std::uint32_t submap_id);

/// The heights between which colours run from red over green to magenta; below and above the colour is that of the end.
struct HeightScale {
  double min_m = -4.0;
  double max_m = 12.0;
};
/// Returns the colour that rviz gives to a point of a cloud coloured by an axis, so that meshes and clouds look alike
/// if their bounds are the same.
Color color_of_height(double z_m, const HeightScale& scale = {});

/// Writes a mesh as binary little-endian PLY.
std::string to_ply(const Mesh& mesh);

}  // namespace voxnav::submap
