// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <octomap/OcTree.h>

#include <memory>
#include <optional>
#include <string>

#include "voxnav/geometry/voxel.hpp"

namespace voxnav::occupancy {

/// The smallest box of voxels around all that were added.
struct VoxelBounds {
  geometry::Index3 low, high;  ///< inclusive
  bool is_empty = true;

  void add(const geometry::Index3& voxel);
};

/// Makes an OcTree of voxels and writes it. The keys of an OctoMap reach 2^15 voxels from its origin in each direction;
/// a map that lies farther off is shifted by whole voxels.
class OctomapWriter {
 public:
  /// @throws std::length_error when the bounds are wider than an OctoMap
  OctomapWriter(double resolution_m, const VoxelBounds& bounds);

  octomap::OcTree& tree() { return tree_; }
  /// What must be added to coordinates in the OcTree to get those of the map, if they differ.
  std::optional<geometry::Vec3> shift_m() const;
  /// The voxel must lie within the bounds. Inner nodes wait for finish().
  void set(const geometry::Index3& voxel, double log_odds);
  void finish();
  /// By the ending of the path `.ot` (log-odds) or `.bt` (occupied and free); a shift stands in a comment of the
  /// header.
  /// @throws std::invalid_argument for another ending, std::runtime_error when the file cannot be written
  void write(const std::string& path);

 private:
  geometry::Index3 shift_;
  octomap::OcTree tree_;
};

struct OctomapFile {
  std::unique_ptr<octomap::OcTree> tree;
  geometry::Index3 shift;  ///< voxels to be added to those of the tree; not zero only in files that OctomapWriter wrote
};

/// Reads `.ot` or `.bt`. @throws std::runtime_error when the file cannot be read as an OcTree
OctomapFile read_octomap(const std::string& path);

}  // namespace voxnav::occupancy
