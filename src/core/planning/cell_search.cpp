// SPDX-License-Identifier: BSD-3-Clause
#include <cmath>

#include "planning/search.hpp"
#include "planning/way_out.hpp"

namespace voxnav::planning {
namespace {

using geometry::Index3;

std::int64_t distance_sq(const Index3& a, const Index3& b) {
  const std::int64_t x = a.x - b.x, y = a.y - b.y, z = a.z - b.z;
  return x * x + y * y + z * z;
}

bool is_enterable(SearchSpace* space, const Index3& voxel) {
  CellRef cell;
  return space->locate(voxel, &cell) && space->cost(cell) != 0;
}

/// Calls fn for each cell whose largest axis offset from the centre is `ring`.
template <class Fn>
void for_each_in_ring(const Index3& center, int ring, Fn fn) {
  for (int z = -ring; z <= ring; ++z) {
    for (int y = -ring; y <= ring; ++y) {
      const bool is_face = std::abs(z) == ring || std::abs(y) == ring;
      const int step = is_face || ring == 0 ? 1 : 2 * ring;
      for (int x = -ring; x <= ring; x += step) fn(center + Index3{x, y, z});
    }
  }
}

}  // namespace

bool nearest_enterable(SearchSpace* space, const Index3& center, double radius_cells, const SearchBudget& budget,
                       Index3* out) {
  const double radius_sq = radius_cells * radius_cells;
  double best_sq = std::numeric_limits<double>::infinity();
  for (int ring = 0; ring <= radius_cells && static_cast<double>(ring) * ring <= best_sq; ++ring) {
    if (budget.is_late()) break;
    for_each_in_ring(center, ring, [&](const Index3& voxel) {
      const auto d = static_cast<double>(distance_sq(voxel, center));
      if (d > radius_sq || d > best_sq || (d == best_sq && !(voxel < *out)) || !is_enterable(space, voxel)) return;
      best_sq = d;
      *out = voxel;
    });
  }
  return std::isfinite(best_sq);
}

std::vector<Index3> escape(SearchSpace* space, CellCosts* costs, const Index3& start, double radius_cells,
                           bool may_cross_unknown, const SearchBudget& budget) {
  const auto may_cross = [&](const Index3& voxel) {
    const VoxelState state = costs->state(voxel);
    return costs->is_inside(voxel) && state != VoxelState::kOccupied &&
           (may_cross_unknown || state == VoxelState::kFree) && !costs->is_fenced(voxel);
  };
  return find_way_out(start, radius_cells,
                      {may_cross, [space](const Index3& voxel) { return is_enterable(space, voxel); },
                       [&budget] { return budget.is_late(); }});
}

}  // namespace voxnav::planning
