// SPDX-License-Identifier: BSD-3-Clause
#include "submap/content/submap_content.hpp"

#include "submap/content/block_states_builder.hpp"

namespace voxnav::submap {

using occupancy::OccupiedVoxel;

bool SubmapContent::is_observed(std::size_t position) const {
  if (states_.has_observed_free(position)) return true;
  const std::size_t first = states_.first_number(position), end = states_.first_number(position + 1);
  return points_.num_observed_before(end) > points_.num_observed_before(first);
}

std::size_t SubmapContent::memory_bytes() const {
  return sizeof(*this) + states_.memory_bytes() + points_.memory_bytes() + (measured_ ? measured_->memory_bytes() : 0);
}

SubmapContent observed_content(const SubmapContent& content) {
  const BlockStates& states = content.states();
  BlockStatesBuilder kept_states;
  kept_states.reserve(states.size());
  VoxelPoints kept_points;
  OccupiedVoxel voxel;
  VoxelPoints::Reader reader(content.points(), 0);
  for (std::size_t i = 0; i < states.size(); ++i) {
    kept_states.begin_block(states.index(i));
    states.for_each_cell(i, [&](int cell, const CellStates& from) {
      CellStates kept{from.free, 0, 0};
      kernels::for_each_bit(from.occupied, [&](int bit) {
        reader.next(&voxel);
        if (voxel.observed.hits == 0) return;
        kept.occupied |= bit_of(bit);
        voxel.believed = voxel.observed;
        kept_points.add(voxel);
      });
      kept_states.add_cell(cell, kept);
    });
  }
  kept_points.finish();
  return {kept_states.finish(), std::move(kept_points), std::nullopt, content.band()};
}

}  // namespace voxnav::submap
