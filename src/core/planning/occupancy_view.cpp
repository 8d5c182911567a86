// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/occupancy_view.hpp"

#include <stdexcept>

namespace voxnav::planning {
namespace {
constexpr double kMaxBlocks = 1e6;
}

const StateBlock* OccupancyView::block(const geometry::Index3& block, StateBlock* scratch) const {
  *scratch = StateBlock{};
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const VoxelState found = state(geometry::voxel_at(block, offset));
    if (found != VoxelState::kUnknown) scratch->set(offset, found);
  }
  return scratch->all_unknown() ? nullptr : scratch;
}

std::vector<geometry::Index3> OccupancyView::known_blocks() const {
  const geometry::Aabb box = bounds();
  std::vector<geometry::Index3> out;
  if (box.empty()) return out;
  const double side_m = geometry::kBlockSide * resolution_m();
  const geometry::Vec3 sides = (box.max - box.min) / side_m + geometry::Vec3::Ones();
  if (!(sides.prod() <= kMaxBlocks)) throw std::length_error("the bounds of the view hold too many blocks to list");
  const geometry::Index3 low = geometry::index_of(box.min, side_m), high = geometry::index_of(box.max, side_m);
  for (int z = low.z; z <= high.z; ++z) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int x = low.x; x <= high.x; ++x) out.push_back({x, y, z});
    }
  }
  return out;
}

bool OccupancyView::forbidden(const geometry::Index3&, BlockMask*, BlockMask*) const { return false; }

}  // namespace voxnav::planning
