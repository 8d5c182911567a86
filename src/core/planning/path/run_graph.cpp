// SPDX-License-Identifier: BSD-3-Clause
#include "planning/path/run_graph.hpp"

namespace voxnav::planning {

std::size_t RunGraph::memory_bytes() const {
  return nodes_.capacity() * sizeof(Node) + towers_.size() * (sizeof(Tower) + 64);
}

const RunGraph::Tower* RunGraph::find_tower(int x, int y) {
  const auto found = by_place_.find({x, y, 0});
  if (found != by_place_.end()) return found->second;
  const VoxelBox& bounds = costs_.field().bounds();
  constexpr int kShift = geometry::kBlockShift;
  if (x < bounds.low.x >> kShift || x > bounds.high.x >> kShift || y < bounds.low.y >> kShift ||
      y > bounds.high.y >> kShift) {
    return nullptr;
  }
  if (memory_bytes() > max_bytes_) {
    has_refused_ = true;
    return nullptr;
  }
  return make_tower(x << kShift, y << kShift);
}

const RunGraph::Tower* RunGraph::make_tower(int x, int y) {
  costs_.find_tower(x, y, &blocks_);
  towers_.push_back(std::make_unique<Tower>());
  Tower& made = *towers_.back();
  const bool is_plain = costs_.is_plain(blocks_);
  for (int i = 0; i < kColumns; ++i) {
    made.first[i] = static_cast<Number>(nodes_.size());
    const int column_x = x + i % geometry::kBlockSide, column_y = y + i / geometry::kBlockSide;
    if (is_plain) {
      const int lowest = blocks_.front().lowest_z;
      for_each_run(RunCosts::plain_column(blocks_, i), [&](int low, int high) {
        nodes_.push_back({column_x, column_y, {lowest + low, lowest + high, kUnitCost}});
      });
    } else {
      costs_.for_each_run_of(blocks_, column_x, column_y, [&](const CellRun& run) {
        nodes_.push_back({column_x, column_y, run});
      });
    }
  }
  made.first[kColumns] = static_cast<Number>(nodes_.size());
  by_place_.emplace(geometry::Index3{x >> geometry::kBlockShift, y >> geometry::kBlockShift, 0}, &made);
  return &made;
}

}  // namespace voxnav::planning
