// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <queue>
#include <random>
#include <tuple>

#include "planning/path/open_list.hpp"

namespace voxnav::planning {
namespace {

/// The order that the list promises: smallest f, then largest cost, then lowest place.
template <class Cost>
using Key = std::tuple<Cost, Cost, std::uint32_t>;

/// Pushes and pops at random, sums far above and below the first one included, beside one heap of all entries.
template <class Cost>
void compare(Cost width, Cost range, unsigned seed) {
  std::mt19937 rng(seed);
  OpenList<Cost, std::uint32_t> list(width);
  std::priority_queue<Key<Cost>, std::vector<Key<Cost>>, std::greater<Key<Cost>>> heap;
  for (int i = 0; i < 20000; ++i) {
    const bool is_push = heap.empty() || rng() % 5 < 3;
    if (is_push) {
      const auto f = static_cast<Cost>(range * (rng() / 4294967296.0)), cost = static_cast<Cost>(rng() % 3);
      const auto place = static_cast<std::uint32_t>(rng() % 50);
      list.push(f, cost, place);
      heap.emplace(f, Cost{2} - cost, place);
    } else {
      const auto entry = list.pop();
      const Key<Cost> expected = heap.top();
      heap.pop();
      ASSERT_EQ(Key<Cost>(entry.f, Cost{2} - entry.cost, entry.place), expected) << "seed " << seed << ", step " << i;
    }
    ASSERT_EQ(list.empty(), heap.empty());
  }
}

TEST(OpenList, GivesTheOrderOfOneHeapWhateverTheWidthOfItsSlots) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    compare<std::uint64_t>(1, 500, seed);
    compare<std::uint64_t>(7, 1000000, seed);
    compare<std::uint64_t>(1u << 20, 1000, seed);
    compare<double>(0.03, 10.0, seed);
    compare<double>(0.03, 5000.0, seed);
  }
}

TEST(OpenList, TakesEntriesWithoutAnEnd) {
  OpenList<double, std::uint32_t> list(1.0);
  const double infinity = std::numeric_limits<double>::infinity();
  list.push(1.0, 0.0, 1);
  list.push(infinity, 0.0, 2);
  list.push(2.0, 0.0, 3);
  EXPECT_EQ(list.pop().place, 1u);
  EXPECT_EQ(list.pop().place, 3u);
  EXPECT_EQ(list.pop().place, 2u);
  EXPECT_TRUE(list.empty());
}

}  // namespace
}  // namespace voxnav::planning
