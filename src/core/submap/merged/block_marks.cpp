// SPDX-License-Identifier: BSD-3-Clause
#include "submap/merged/block_marks.hpp"

#include <algorithm>

namespace voxnav::submap {
namespace {

using geometry::Index3;

struct Box {
  Index3 low, high;
};

Box box_of(const std::vector<Index3>& blocks) {
  Box box{blocks.front(), blocks.front()};
  for (const Index3& b : blocks) {
    box.low = {std::min(box.low.x, b.x), std::min(box.low.y, b.y), std::min(box.low.z, b.z)};
    box.high = {std::max(box.high.x, b.x), std::max(box.high.y, b.y), std::max(box.high.z, b.z)};
  }
  return box;
}

void sort_by_comparing(std::vector<Index3>* blocks) {
  std::sort(blocks->begin(), blocks->end());
  blocks->erase(std::unique(blocks->begin(), blocks->end()), blocks->end());
}

}  // namespace

BlockMarks::BlockMarks(const Index3& low, const Index3& high)
    : low_(low),
      size_x_(static_cast<std::size_t>(high.x - low.x) + 1),
      size_y_(static_cast<std::size_t>(high.y - low.y) + 1),
      words_((size_x_ * size_y_ * (static_cast<std::size_t>(high.z - low.z) + 1) + 63) / 64) {}

bool BlockMarks::fits(const Index3& low, const Index3& high) {
  constexpr double kMost = 1 << 26;  // 8 MB
  const auto size = [](std::int32_t a, std::int32_t b) { return static_cast<double>(b) - a + 1.0; };
  return size(low.x, high.x) * size(low.y, high.y) * size(low.z, high.z) <= kMost;
}

std::vector<Index3> BlockMarks::sorted() const {
  std::vector<Index3> out;
  for (std::size_t i = 0; i < words_.size(); ++i) {
    for (std::uint64_t word = words_[i]; word != 0; word &= word - 1) {
      const std::size_t bit = 64 * i + static_cast<std::size_t>(__builtin_ctzll(word));
      const std::size_t row = bit / size_x_;
      out.push_back(low_ + Index3{static_cast<std::int32_t>(bit % size_x_), static_cast<std::int32_t>(row % size_y_),
                                  static_cast<std::int32_t>(row / size_y_)});
    }
  }
  return out;
}

void sort_unique(std::vector<Index3>* blocks) {
  constexpr std::size_t kFew = 64;
  if (blocks->size() < kFew) return sort_by_comparing(blocks);
  const Box box = box_of(*blocks);
  if (!BlockMarks::fits(box.low, box.high)) return sort_by_comparing(blocks);
  BlockMarks marks(box.low, box.high);
  for (const Index3& block : *blocks) marks.mark(block);
  *blocks = marks.sorted();
}

void dilate(int reach, std::vector<Index3>* blocks) {
  if (blocks->empty()) return;
  const Index3 step{reach, reach, reach};
  const Box box = box_of(*blocks);
  const bool fits = BlockMarks::fits(box.low - step, box.high + step);
  BlockMarks marks(fits ? box.low - step : Index3{}, fits ? box.high + step : Index3{});
  std::vector<Index3> spread;
  for (const Index3& block : *blocks) {
    for (int z = -reach; z <= reach; ++z) {
      for (int y = -reach; y <= reach; ++y) {
        for (int x = -reach; x <= reach; ++x) {
          const Index3 near = block + Index3{x, y, z};
          fits ? marks.mark(near) : spread.push_back(near);
        }
      }
    }
  }
  if (fits) {
    *blocks = marks.sorted();
  } else {
    sort_by_comparing(&spread);
    *blocks = std::move(spread);
  }
}

}  // namespace voxnav::submap
