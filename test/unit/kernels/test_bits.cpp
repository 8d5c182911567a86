// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <random>
#include <vector>

#include "kernels/bits.hpp"
#include "sparse_bits.hpp"

using namespace voxnav;  // NOLINT: test

TEST(Bits, CountsEqualTheReference) {
  std::mt19937_64 rng(1);
  EXPECT_EQ(kernels::count_bits(0), 0u);
  EXPECT_EQ(kernels::count_bits(~std::uint64_t{0}), 64u);
  for (int trial = 0; trial < 1000; ++trial) {
    const std::uint64_t word = trial % 2 == 0 ? rng() : test::sparse_bits(&rng, 3);
    ASSERT_EQ(kernels::count_bits(word), kernels::reference::count_bits(word));
  }
}

TEST(Bits, AreVisitedOnceFromTheLowest) {
  std::mt19937_64 rng(2);
  for (int trial = 0; trial < 100; ++trial) {
    const std::uint64_t word = test::sparse_bits(&rng, 2);
    std::vector<int> visited, expected;
    kernels::for_each_bit(word, [&](int bit) { visited.push_back(bit); });
    for (int i = 0; i < 64; ++i) {
      if (((word >> i) & 1u) != 0) expected.push_back(i);
    }
    ASSERT_EQ(visited, expected);
  }
}

TEST(Bits, TransposedMatricesEqualTheReference) {
  std::mt19937_64 rng(6);
  for (int trial = 0; trial < 200; ++trial) {
    std::array<std::uint16_t, 16> rows{}, columns{}, expected{};
    for (auto& row : rows) row = static_cast<std::uint16_t>(test::sparse_bits(&rng, 2));
    kernels::transpose_16(rows.data(), columns.data());
    kernels::reference::transpose_16(rows.data(), expected.data());
    ASSERT_EQ(columns, expected);
    for (int k = 0; k < 16; ++k) {
      for (int i = 0; i < 16; ++i) ASSERT_EQ((columns[k] >> i) & 1, (rows[i] >> k) & 1);
    }
  }
}
