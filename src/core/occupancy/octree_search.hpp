// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>

#include "occupancy/octree_forest.hpp"
#include "voxnav/geometry/aabb.hpp"

/// Depth-first search from the roots to the voxels. A visitor has
///   bool enter(center, half_edge, flags)   whether anything below the node matters (flags: Contains bits)
///   void leaf(center, half_edge, flags)    a voxel, or a whole block of which nothing is known
/// or, for search_surface, `void surface(mean hit point)` of occupied voxels instead of leaf().
namespace voxnav::occupancy {
namespace detail {

template <class LeafVisit, class Visitor>
void search_node(const OctreeBlock& block, const geometry::Index3& block_index, int level, int x, int y, int z,
                 double resolution_m, const StateLevels& levels, Visitor* visitor, const LeafVisit& visit_leaf) {
  const int side = 1 << level;
  const double half_edge = 0.5 * side * resolution_m;
  const geometry::Vec3 low(block_index.x * geometry::kBlockSide + x * side,
                           block_index.y * geometry::kBlockSide + y * side,
                           block_index.z * geometry::kBlockSide + z * side);
  const geometry::Vec3 center = low * resolution_m + geometry::Vec3::Constant(half_edge);
  if (level == 0) {
    const int offset = geometry::offset_in_block({x, y, z});
    const auto flags = static_cast<std::uint8_t>(1u << static_cast<int>(levels.of(block.log_odds[offset])));
    if (visitor->enter(center, half_edge, flags)) visit_leaf(offset, center, half_edge, flags);
    return;
  }
  if (!visitor->enter(center, half_edge, block.node_flags(level, x, y, z))) return;
  for (int child = 0; child < 8; ++child) {
    search_node(block, block_index, level - 1, 2 * x + (child & 1), 2 * y + ((child >> 1) & 1), 2 * z + (child >> 2),
                resolution_m, levels, visitor, visit_leaf);
  }
}

/// Calls on_block(index, block) for each block that overlaps the box, with null for a block of which nothing is known.
/// Outside the window only the layer of blocks next to it is visited, which keeps the search bounded: every path that
/// leaves the window crosses that layer.
template <class OnBlock>
void for_blocks_in(const OctreeForest& forest, const geometry::Aabb& box, const OnBlock& on_block) {
  const BlockWindow& window = forest.window;
  const double size_m = forest.resolution_m * geometry::kBlockSide;
  const geometry::Index3 first = window.first_block();
  const auto& n = window.num_blocks();
  geometry::Index3 low = geometry::index_of(box.min, size_m);
  geometry::Index3 high = geometry::index_of(box.max, size_m);
  low = {std::max(low.x, first.x - 1), std::max(low.y, first.y - 1), std::max(low.z, first.z - 1)};
  high = {std::min(high.x, first.x + n[0]), std::min(high.y, first.y + n[1]), std::min(high.z, first.z + n[2])};
  geometry::Index3 i;
  for (i.z = low.z; i.z <= high.z; ++i.z) {
    for (i.y = low.y; i.y <= high.y; ++i.y) {
      for (i.x = low.x; i.x <= high.x; ++i.x) on_block(i, window.find(i));
    }
  }
}

}  // namespace detail

template <class Visitor>
void search_octree(const OctreeForest& forest, const geometry::Aabb& box, Visitor* visitor) {
  const double half_edge = 0.5 * forest.resolution_m * geometry::kBlockSide;
  detail::for_blocks_in(forest, box, [&](const geometry::Index3& index, const OctreeBlock* block) {
    const geometry::Vec3 center = geometry::center_of(index, 2.0 * half_edge);
    if (block == nullptr) {
      if (visitor->enter(center, half_edge, kContainsUnknown)) visitor->leaf(center, half_edge, kContainsUnknown);
      return;
    }
    detail::search_node(
        *block, index, OctreeBlock::kLevels, 0, 0, 0, forest.resolution_m, forest.levels, visitor,
        [&](int, const geometry::Vec3& c, double h, std::uint8_t flags) { visitor->leaf(c, h, flags); });
  });
}

template <class Visitor>
void search_surface(const OctreeForest& forest, const geometry::Aabb& box, Visitor* visitor) {
  detail::for_blocks_in(forest, box, [&](const geometry::Index3& index, const OctreeBlock* block) {
    if (block == nullptr) return;
    detail::search_node(
        *block, index, OctreeBlock::kLevels, 0, 0, 0, forest.resolution_m, forest.levels, visitor,
        [&](int offset, const geometry::Vec3& c, double, std::uint8_t) {
          const SurfaceLeaf* leaf = block->leaves.find(offset);
          visitor->surface(leaf ? geometry::Vec3(c + leaf->offset().cast<double>() * forest.resolution_m) : c);
        });
  });
}

}  // namespace voxnav::occupancy
