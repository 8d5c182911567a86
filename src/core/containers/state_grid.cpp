// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/containers/state_grid.hpp"

#include <algorithm>
#include <stdexcept>

namespace voxnav::containers {

bool StateBlock::all_unknown() const {
  return std::all_of(words.begin(), words.end(), [](std::uint64_t word) { return word == 0; });
}

StateGrid::StateGrid(double resolution_m) : resolution_m_(resolution_m) {
  if (!(resolution_m > 0.0)) throw std::invalid_argument("resolution_m must be positive");
}

VoxelState StateGrid::state(const geometry::Index3& voxel) const {
  const StateBlock* found = find_block(geometry::block_of(voxel));
  return found ? found->get(geometry::offset_in_block(voxel)) : VoxelState::kUnknown;
}

VoxelState StateGrid::state(const geometry::Vec3& point) const {
  // The index of a voxel beyond 2^30 would overflow; nothing is ever known that far away.
  if (!((point.array().abs() / resolution_m_) < 1073741824.0).all()) return VoxelState::kUnknown;
  return state(geometry::index_of(point, resolution_m_));
}

void StateGrid::set(const geometry::Index3& voxel, VoxelState state) {
  blocks_[geometry::block_of(voxel)].set(geometry::offset_in_block(voxel), state);
}

const StateBlock* StateGrid::find_block(const geometry::Index3& block) const {
  const auto it = blocks_.find(block);
  return it == blocks_.end() ? nullptr : &it->second;
}

void StateGrid::replace_block(const geometry::Index3& block, const StateBlock& states) {
  if (states.all_unknown()) {
    blocks_.erase(block);
  } else {
    blocks_[block] = states;
  }
}

std::vector<geometry::Index3> StateGrid::sorted_block_indices() const {
  std::vector<geometry::Index3> out;
  out.reserve(blocks_.size());
  for (const auto& entry : blocks_) out.push_back(entry.first);
  std::sort(out.begin(), out.end());
  return out;
}

std::size_t StateGrid::memory_bytes() const {
  return sizeof(*this) + blocks_.size() * (sizeof(Blocks::value_type) + 2 * sizeof(void*)) +
         blocks_.bucket_count() * sizeof(void*);
}

}  // namespace voxnav::containers
