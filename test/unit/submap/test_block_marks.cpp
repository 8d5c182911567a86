// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <set>

#include "submap/merged/block_marks.hpp"

using voxnav::geometry::Index3;

namespace {

std::vector<Index3> random_blocks(unsigned seed, int count, int reach) {
  std::mt19937 rng(seed);
  std::uniform_int_distribution<int> draw(-reach, reach);
  std::vector<Index3> out;
  for (int i = 0; i < count; ++i) {
    const int x = draw(rng);
    const int y = draw(rng);
    out.push_back({x, y, draw(rng) / 4});
  }
  return out;
}

std::vector<Index3> as_sorted(const std::set<Index3>& blocks) { return {blocks.begin(), blocks.end()}; }

}  // namespace

TEST(BlockMarks, SortsAndDropsRepeatsAsASetDoes) {
  for (const auto& [count, reach] : {std::pair{10, 3}, {2000, 9}, {2000, 30}, {300, 60000000}}) {
    std::vector<Index3> blocks = random_blocks(1, count, reach);
    const std::set<Index3> expected(blocks.begin(), blocks.end());
    voxnav::submap::sort_unique(&blocks);
    EXPECT_EQ(blocks, as_sorted(expected));
  }
  std::vector<Index3> none;
  voxnav::submap::sort_unique(&none);
  EXPECT_TRUE(none.empty());
}

TEST(BlockMarks, DilatesByWholeBlocks) {
  for (const int reach : {20, 60000000}) {
    std::vector<Index3> blocks = random_blocks(2, 60, reach);
    std::set<Index3> expected;
    for (const Index3& b : blocks) {
      for (int i = 0; i < 125; ++i) expected.insert(b + Index3{i % 5 - 2, i / 5 % 5 - 2, i / 25 - 2});
    }
    voxnav::submap::dilate(2, &blocks);
    EXPECT_EQ(blocks, as_sorted(expected));
  }
}
