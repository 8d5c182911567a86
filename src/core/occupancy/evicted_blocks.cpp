// SPDX-License-Identifier: BSD-3-Clause
#include "occupancy/evicted_blocks.hpp"

#include <utility>

namespace voxnav::occupancy {

void EvictedBlocks::add(ContentBlock block) {
  const auto it = blocks_.find(block.index);
  if (it != blocks_.end()) {
    MapContent older{resolution_m_, {std::move(it->second)}};
    older.merge(MapContent{resolution_m_, {std::move(block)}});
    it->second = std::move(older.blocks.front());
  } else if (blocks_.size() < max_blocks_) {
    const geometry::Index3 index = block.index;
    blocks_.emplace(index, std::move(block));
  } else {
    ++num_dropped_;
  }
}

MapContent EvictedBlocks::take() {
  MapContent out;
  out.resolution_m = resolution_m_;
  for (auto& entry : blocks_) out.blocks.push_back(std::move(entry.second));
  blocks_.clear();
  return out;
}

std::size_t EvictedBlocks::memory_bytes() const {
  std::size_t bytes = 0;
  for (const auto& entry : blocks_) bytes += sizeof(entry) + entry.second.occupied.capacity() * sizeof(OccupiedVoxel);
  return bytes;
}

}  // namespace voxnav::occupancy
