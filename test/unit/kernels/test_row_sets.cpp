// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "kernels/row_sets.hpp"
#include "sparse_bits.hpp"

using namespace voxnav;  // NOLINT: test

TEST(RowSets, ExtentsEqualTheReference) {
  std::mt19937 rng(1);
  std::normal_distribution<float> number(0.0f, 50.0f);
  for (std::size_t n = 0; n < 70; ++n) {
    std::vector<float> numbers(n);
    for (float& x : numbers) x = number(rng);
    const float other = number(rng);
    const kernels::Extent extent = kernels::extent_of(numbers.data(), n, other);
    const kernels::Extent expected = kernels::reference::extent_of(numbers.data(), n, other);
    EXPECT_EQ(extent.low, expected.low);
    EXPECT_EQ(extent.high, expected.high);
  }
}

TEST(RowSets, UnionsEqualTheReference) {
  test::with_every_instruction_set([] {
    std::mt19937 rng(2);
    for (std::size_t count = 1; count < 60; count += 3) {
      const auto step = static_cast<std::ptrdiff_t>(count + rng() % 9);
      std::vector<std::uint32_t> rows(static_cast<std::size_t>(step) * kernels::kUnitedRows + count);
      for (auto& word : rows) word = static_cast<std::uint32_t>(test::sparse_bits(&rng, 4));
      std::vector<std::uint32_t> all(count), expected(count);
      kernels::unite_rows(rows.data(), count, step, all.data());
      kernels::reference::unite_rows(rows.data(), count, step, expected.data());
      EXPECT_EQ(all, expected);
    }
  });
}
