// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/occupancy_view.hpp"

namespace voxnav::planning {

const StateBlock* OccupancyView::block(const geometry::Index3& block, StateBlock* scratch) const {
  *scratch = StateBlock{};
  for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
    const VoxelState found = state(geometry::voxel_at(block, offset));
    if (found != VoxelState::kUnknown) scratch->set(offset, found);
  }
  return scratch->all_unknown() ? nullptr : scratch;
}

bool OccupancyView::forbidden(const geometry::Index3&, BlockMask*, BlockMask*) const { return false; }

}  // namespace voxnav::planning
