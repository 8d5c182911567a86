// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <vector>

#include "voxnav/geometry/aabb.hpp"
#include "voxnav/occupancy/new_hit.hpp"

namespace voxnav::occupancy {

/// Hits of one scan that are connected: each is in a neighbouring cell of another.
struct HitCluster {
  std::vector<std::size_t> hits;                   ///< indices into the list of hits, rising
  geometry::Aabb box;                              ///< around the points of the hits
  geometry::Vec3 center = geometry::Vec3::Zero();  ///< mean of their points; each voxel counts once
  int num_returns = 0;                             ///< in all of its voxels

  void add(std::size_t index, const NewHit& hit);
  void add(const HitCluster& other);
};

/// Finds the connected parts of those hits of a list that are clear (NewHit). Cells have the edge `cell_m`, and 26
/// neighbours each.
/// @return clusters with many hits first; equal ones in the order of their first hits
/// O(n log n).
std::vector<HitCluster> connected_hits(const std::vector<NewHit>& hits, double cell_m);

}  // namespace voxnav::occupancy
