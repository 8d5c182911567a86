// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "occupancy/octomap_nodes.hpp"

namespace voxnav::occupancy {

/// The smallest box of voxels around all that were added.
struct VoxelBounds {
  geometry::Index3 low, high;  ///< inclusive
  bool is_empty = true;

  void add(const geometry::Index3& voxel);
};

/// The form of a file by the ending of its path: `.ot` full, `.bt` binary. @throws std::invalid_argument for another
/// one
OctomapForm octomap_form_of(const std::string& path);

/// What must be added to coordinates in an OctoMap to get those of the map, if they differ.
std::optional<geometry::Vec3> shift_m(const OctomapNodes& nodes, double resolution_m);

/// Writes a file that OctoMap reads. A shift stands in a comment of its header.
/// @param form  that of the nodes and of the path
/// @throws std::runtime_error when the file cannot be written
void write_octomap(const OctomapNodes& nodes, OctomapForm form, double resolution_m, const std::string& path);

/// A leaf: a cube of voxels, which are those of the map, so that a shift of the file is already added.
struct OctomapLeaf {
  std::array<std::int64_t, 3> low;  ///< its lowest voxel
  std::int64_t side;                ///< voxels along each edge
  float log_odds;
};

struct OctomapFile {
  double resolution_m = 0.0;
  std::vector<OctomapLeaf> leaves;
};

/// Reads an OcTree from a file of OctoMap. The library of OctoMap reads beyond the end of broken files; here every byte
/// is checked. O(nodes of the file).
/// @throws std::runtime_error naming the file and what is wrong with it
OctomapFile read_octomap(const std::string& path);

}  // namespace voxnav::occupancy
