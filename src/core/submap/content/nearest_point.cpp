// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/nearest_point.hpp"

#include <cstdlib>

namespace voxnav::submap {
namespace {

using geometry::Index3;
using geometry::Vec3;

/// Returns the squared distance from p to the cube of `side` voxels that starts at `lower`, and its nearest point if
/// asked for.
double squared_to_cube(const Vec3& p, const Index3& lower, double side, Vec3* nearest = nullptr) {
  const Vec3 low(lower.x, lower.y, lower.z);
  const Vec3 on_cube = p.cwiseMax(low).cwiseMin(low + Vec3::Constant(side));
  if (nearest) *nearest = on_cube;
  return (p - on_cube).squaredNorm();
}

double squared_to_block(const Vec3& p, const Index3& block) {
  return squared_to_cube(p, geometry::voxel_at(block, 0), geometry::kBlockSide);
}

/// One branch-and-bound search: blocks, then cells, then voxels that lie farther than the best so far are skipped.
class Search {
 public:
  Search(const SubmapContent& content, const Vec3& p, double limit, NearestTarget target)
      : content_(content), p_(p), target_(target), best_{Vec3::Zero(), limit} {}

  const NearestPoint& best() const { return best_; }
  void look_into(std::size_t position) {
    const BlockStates& states = content_.states();
    if (!states.has_occupied(position)) return;
    const Index3& index = states.index(position);
    if (!(squared_to_block(p_, index) < best_.squared)) return;
    states.for_each_occupied_cell(position, [&](int cell, std::uint64_t occupied, std::size_t number) {
      const Index3 first = geometry::voxel_at(index, offset_of(cell, 0));
      if (squared_to_cube(p_, first, kCellSide) >= best_.squared) return;
      kernels::for_each_bit(occupied, [&](int voxel) {
        look_at(geometry::voxel_at(index, offset_of(cell, voxel)), content_.points().believed(number++));
      });
    });
  }

 private:
  void look_at(const Index3& voxel, const occupancy::VoxelPoint& in_voxel) {
    Vec3 point = surface_point(voxel, in_voxel);
    const double squared =
        target_ == NearestTarget::kSurfacePoint ? (p_ - point).squaredNorm() : squared_to_cube(p_, voxel, 1.0, &point);
    if (squared < best_.squared) best_ = {point, squared};
  }

  const SubmapContent& content_;
  const Vec3 p_;
  const NearestTarget target_;
  NearestPoint best_;
};

/// Calls f(step) for every block of the shell with radius `shell` around a block: the blocks whose largest offset on
/// any axis is `shell`.
template <class F>
void for_each_of_shell(int shell, F&& f) {
  for (int z = -shell; z <= shell; ++z) {
    for (int y = -shell; y <= shell; ++y) {
      const bool is_side = std::abs(z) == shell || std::abs(y) == shell;
      for (int x = -shell; x <= shell; x += is_side || shell == 0 ? 1 : 2 * shell) f(Index3{x, y, z});
    }
  }
}

}  // namespace

std::optional<NearestPoint> find_nearest(const SubmapContent& content, const Vec3& p, double max_distance,
                                         NearestTarget target) {
  const BlockStates& states = content.states();
  const double limit = max_distance * max_distance;
  Search search(content, p, limit, target);
  const Index3 center = geometry::index_of(p, geometry::kBlockSide);
  const int last_shell = static_cast<int>(max_distance / geometry::kBlockSide) + 1;
  for (int shell = 0; shell <= last_shell; ++shell) {
    // Every block of this shell is at least `reach` away from p, the width of the blocks in between.
    const double reach = (shell - 1) * static_cast<double>(geometry::kBlockSide);
    if (shell > 1 && reach * reach >= search.best().squared) break;
    // If the shell has more places than the submap has blocks, the list of blocks is searched instead.
    if (24.0 * shell * shell > static_cast<double>(states.size())) {
      for (std::size_t i = 0; i < states.size(); ++i) search.look_into(i);
      break;
    }
    for_each_of_shell(shell, [&](const Index3& step) {
      if (squared_to_block(p, center + step) >= search.best().squared) return;
      const auto position = states.find(center + step);
      if (position) search.look_into(*position);
    });
  }
  if (search.best().squared >= limit) return std::nullopt;
  return search.best();
}

}  // namespace voxnav::submap
