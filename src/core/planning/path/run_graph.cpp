// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/run_graph.hpp"

namespace voxnav::planning {

RunGraph::Column RunGraph::column(int x, int y) {
  const Tower* found = tower(x >> geometry::kBlockShift, y >> geometry::kBlockShift);
  if (found == nullptr) return {};
  const int at = column_at(x & (geometry::kBlockSide - 1), y & (geometry::kBlockSide - 1));
  return {found->first[at], found->first[at + 1]};
}

RunGraph::Number RunGraph::find(const geometry::Index3& voxel) {
  const Column there = column(voxel.x, voxel.y);
  for (Number n = there.first; n < there.end; ++n) {
    if (nodes_[n].run.low <= voxel.z && voxel.z <= nodes_[n].run.high) return n;
  }
  return kNone;
}

std::size_t RunGraph::memory_bytes() const {
  return nodes_.capacity() * sizeof(Node) + towers_.size() * (sizeof(Tower) + 64);
}

const RunGraph::Tower* RunGraph::tower(int x, int y) {
  const geometry::Index3 place{x, y, 0};
  if (place == last_place_) return last_;
  last_place_ = place;
  const auto found = by_place_.find(place);
  if (found != by_place_.end()) return last_ = found->second;
  const VoxelBox& bounds = costs_.field().bounds();
  constexpr int kShift = geometry::kBlockShift;
  if (x < bounds.low.x >> kShift || x > bounds.high.x >> kShift || y < bounds.low.y >> kShift ||
      y > bounds.high.y >> kShift) {
    return last_ = nullptr;
  }
  if (memory_bytes() > max_bytes_) {
    has_refused_ = true;
    return last_ = nullptr;
  }
  blocks_.clear();
  for (int z = costs_.lowest_block(); z <= costs_.highest_block(); ++z) {
    blocks_.push_back(costs_.field().block_of({x << kShift, y << kShift, z << kShift}));
  }
  auto made = std::make_unique<Tower>();
  for (int i = 0; i < kColumns; ++i) {
    made->first[i] = static_cast<Number>(nodes_.size());
    const int column_x = (x << kShift) + i % geometry::kBlockSide, column_y = (y << kShift) + i / geometry::kBlockSide;
    costs_.for_each_run_of(blocks_, column_x, column_y, [&](const CellRun& run) {
      nodes_.push_back({column_x, column_y, run});
    });
  }
  made->first[kColumns] = static_cast<Number>(nodes_.size());
  last_ = made.get();
  by_place_.emplace(place, last_);
  towers_.push_back(std::move(made));
  return last_;
}

}  // namespace voxnav::planning
