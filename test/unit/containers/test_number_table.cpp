// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <map>
#include <random>
#include <vector>

#include "containers/number_table.hpp"
#include "voxnav/geometry/voxel.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Index3;

namespace {

using Table = containers::NumberTable<Index3, geometry::Index3Hash>;

/// A hash that gives all keys the same slot.
struct SameSlot {
  std::size_t operator()(int) const { return 12345; }
};

Index3 random_index(std::mt19937* rng, int side) {
  std::uniform_int_distribution<int> coordinate(-side, side);
  return {coordinate(*rng), coordinate(*rng), coordinate(*rng)};
}

}  // namespace

TEST(NumberTable, AgreesWithAMapWhileItGrows) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    std::mt19937 rng(seed);
    Table table;
    std::vector<Index3> keys;
    const auto key_of = [&](std::uint32_t number) { return keys[number]; };
    std::map<Index3, std::uint32_t> expected;
    for (int i = 0; i < 5000; ++i) {
      const Index3 key = random_index(&rng, 8);
      const auto next = static_cast<std::uint32_t>(keys.size());
      const auto [entry, is_new] = expected.insert({key, next});
      ASSERT_EQ(table.insert(key, next, key_of), entry->second);
      if (is_new) keys.push_back(key);
      const Index3 other = random_index(&rng, 9);
      const auto found = expected.find(other);
      const auto number = table.find(other, key_of);
      ASSERT_EQ(number.has_value(), found != expected.end());
      if (number) {
        ASSERT_EQ(*number, found->second);
      }
    }
    EXPECT_EQ(table.size(), keys.size());
    EXPECT_LE(table.memory_bytes(), 4 * sizeof(std::uint32_t) * keys.size());
  }
}

TEST(NumberTable, FindsNothingBeforeTheFirstInsertionAndAfterClearing) {
  std::vector<Index3> keys{{1, 2, 3}, {-4, 5, 6}};
  const auto key_of = [&](std::uint32_t number) { return keys[number]; };
  Table table;
  EXPECT_FALSE(table.find(keys[0], key_of));
  table.clear();
  EXPECT_FALSE(table.find(keys[0], key_of));
  for (const bool clears : {true, false}) {
    table.insert(keys[0], 0, key_of);
    table.insert(keys[1], 1, key_of);
    EXPECT_EQ(table.find(keys[1], key_of), 1u);
    clears ? table.clear() : table.reset(100);
    EXPECT_EQ(table.size(), 0u);
    EXPECT_FALSE(table.find(keys[0], key_of));
    EXPECT_FALSE(table.find(keys[1], key_of));
  }
}

TEST(KeyNumbers, NumbersKeysInTheOrderOfTheirFirstUse) {
  containers::KeyNumbers<Index3, geometry::Index3Hash> numbers;
  std::mt19937 rng(7);
  for (int round = 0; round < 3; ++round) {
    round == 1 ? numbers.reset(10) : numbers.clear();
    std::map<Index3, std::uint32_t> expected;
    for (int i = 0; i < 2000; ++i) {
      const Index3 key = random_index(&rng, 6);
      const auto next = static_cast<std::uint32_t>(expected.size());
      ASSERT_EQ(numbers.number_of(key), expected.insert({key, next}).first->second);
      ASSERT_EQ(numbers.size(), expected.size());
    }
  }
}

TEST(NumberTable, KeysWithTheSameHashAreToldApart) {
  containers::NumberTable<int, SameSlot> table;
  const auto key_of = [](std::uint32_t number) { return static_cast<int>(number) * 7; };
  for (std::uint32_t i = 0; i < 200; ++i) EXPECT_EQ(table.insert(key_of(i), i, key_of), i);
  for (std::uint32_t i = 0; i < 200; ++i) EXPECT_EQ(table.find(key_of(i), key_of), i);
  EXPECT_FALSE(table.find(3, key_of));
}
