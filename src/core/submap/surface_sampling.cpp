// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/submap/surface_sampling.hpp"

#include <algorithm>

#include "voxnav/submap/compressed_field.hpp"

namespace voxnav::submap {
namespace {

using geometry::SurfacePoint;
using geometry::Vec3;

struct Candidate {
  geometry::Index3 block;
  const FilledLeaf* leaf;
};
using Cell = std::vector<Candidate>;

float weight_of(const FilledLeaf& leaf) {
  constexpr float kHalfway = 3.f;  // hits that give half of the full weight
  const float hits = std::max<float>(leaf.hits, 1.f);
  return leaf.quality * hits / (hits + kHalfway);
}

/// Leaves with a normal, by cell, best first.
std::vector<Cell> candidates(const std::vector<FilledBlock>& blocks) {
  std::vector<Cell> out;
  for (const FilledBlock& block : blocks) {
    std::array<Cell, 64> cells;
    for (const FilledLeaf& leaf : block.leaves) {
      if (leaf.quality > 0.f)
        cells[static_cast<std::size_t>(CompressedField::cell_of(leaf.offset))].push_back({block.index, &leaf});
    }
    for (Cell& cell : cells) {
      if (cell.empty()) continue;
      std::stable_sort(cell.begin(), cell.end(),
                       [](const Candidate& a, const Candidate& b) { return weight_of(*a.leaf) > weight_of(*b.leaf); });
      out.push_back(std::move(cell));
    }
  }
  return out;
}

SurfacePoint point_of(const Candidate& candidate, double resolution_m, const geometry::Pose& T_S_G) {
  const geometry::Index3 voxel = geometry::voxel_at(candidate.block, candidate.leaf->offset);
  const Vec3 p_G = surface_point(voxel, {candidate.leaf->mean, candidate.leaf->hits}) * resolution_m;
  const Vec3 normal = T_S_G.linear() * candidate.leaf->normal.cast<double>();
  return {(T_S_G * p_G).cast<float>(), normal.cast<float>(), weight_of(*candidate.leaf)};
}

}  // namespace

std::vector<SurfacePoint> sample_surface(const std::vector<FilledBlock>& blocks, double resolution_m,
                                         const geometry::Pose& T_S_G, int max_points) {
  const std::vector<Cell> cells = candidates(blocks);
  std::vector<SurfacePoint> out;
  const auto limit = static_cast<std::size_t>(max_points);
  for (std::size_t round = 0; round < 64; ++round) {
    std::vector<const Candidate*> next;
    for (const Cell& cell : cells) {
      if (round < cell.size()) next.push_back(&cell[round]);
    }
    if (next.empty() || out.size() >= limit) break;
    // In the last round the places left go to evenly spaced cells, not to the first ones.
    const std::size_t take = std::min(next.size(), limit - out.size());
    for (std::size_t i = 0; i < take; ++i) out.push_back(point_of(*next[i * next.size() / take], resolution_m, T_S_G));
  }
  return out;
}

}  // namespace voxnav::submap
