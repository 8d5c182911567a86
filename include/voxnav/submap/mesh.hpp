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
  std::vector<geometry::Vec3f> vertices;                ///< m
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< counter-clockwise seen from free space
  std::vector<Color> colors;                            ///< per vertex, or empty

  /// Adds another mesh with its colours.
  void append(const Mesh& other);
};

/// Zero level of the stored distances of a submap, frame S. Only cubes whose eight corners all have distances are
/// looked at; those lie within two voxels of occupied ones, so that nothing floats at the edge of what is known.
/// Stops at max_triangles. Closed wherever the stored distances are. O(stored distances).
/// Source: Lorensen & Cline 1987; polygons are traced along the faces with inside corners kept apart on ambiguous
/// faces, which makes neighbouring cubes agree without a table of cases.
Mesh extract_mesh(const Submap& submap, std::size_t max_triangles = 10000000);

/// Zero level of the merged map in W, cubes of the given blocks only, so that a change costs what it touches and the
/// meshes of neighbouring blocks meet. What newer evidence has removed is not in it, and nothing is in it twice.
/// Coloured by height. Stops at max_triangles. O(surface points of the blocks and around them).
Mesh extract_mesh(const EvidenceMap& evidence, const std::vector<geometry::Index3>& blocks,
                  std::size_t max_triangles = 10000000);

/// The same of the whole map, brought up to date first.
Mesh extract_mesh(SubmapCollection* collection, std::size_t max_triangles = 10000000);

/// Same id, same colour; neighbouring ids differ clearly.
Color color_of(std::uint32_t submap_id);

/// Heights between which colours run from red over green to magenta; what is lower or higher has the colour of the end.
struct HeightScale {
  double min_m = -4.0;
  double max_m = 12.0;
};
/// The rainbow of rviz' point clouds that are coloured by an axis, so that both agree where their bounds do.
Color color_of_height(double z_m, const HeightScale& scale = {});

/// Binary little-endian PLY.
std::string to_ply(const Mesh& mesh);

}  // namespace voxnav::submap
