// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <array>
#include <random>

#include "instruction_sets.hpp"
#include "kernels/masked_bytes.hpp"
#include "sparse_bits.hpp"

using namespace voxnav;  // NOLINT: test

namespace {

using Cells = std::array<std::uint8_t, 64>;

Cells random_cells(std::mt19937_64* rng) {
  Cells out{};
  for (auto& cell : out) cell = static_cast<std::uint8_t>((*rng)());
  return out;
}

void expect_same(const kernels::Subtracted& done, const kernels::Subtracted& expected) {
  EXPECT_EQ(done.any_changed, expected.any_changed);
  EXPECT_EQ(done.crossed_free, expected.crossed_free);
  EXPECT_EQ(done.crossed_occupied, expected.crossed_occupied);
}

}  // namespace

TEST(MaskedBytes, EveryFormOfTheSubtractionEqualsTheReference) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 1000; ++trial) {
    const Cells before = trial % 10 == 0 ? Cells{} : random_cells(&rng);
    const std::uint64_t mask = trial % 7 == 0 ? ~std::uint64_t{0} : test::sparse_bits(&rng, 2);
    const kernels::Subtraction by{static_cast<std::uint8_t>(rng()), static_cast<std::uint8_t>(rng()),
                                  static_cast<std::uint8_t>(rng())};
    Cells expected = before, cells = before, wide = before;
    const auto reference = kernels::reference::subtract_where(expected.data(), mask, by);
    expect_same(kernels::subtract_where(cells.data(), mask, by), reference);
    ASSERT_EQ(cells, expected);
    if (!kernels::is_wide()) continue;
    expect_same(kernels::subtract_where_wide(wide.data(), mask, by), reference);
    ASSERT_EQ(wide, expected);
  }
}

TEST(MaskedBytes, WholeBlocksEqualTheReference) {
  test::with_every_instruction_set([] {
    std::mt19937_64 rng(7);
    for (int trial = 0; trial < 50; ++trial) {
      std::array<std::uint8_t, 4096> cells{};
      std::array<std::uint64_t, kernels::kBlockWords> masks{};
      for (auto& cell : cells) cell = static_cast<std::uint8_t>(rng());
      for (auto& mask : masks) mask = rng() % 3 == 0 ? 0 : test::sparse_bits(&rng, 2);
      auto expected = cells;
      const kernels::Subtraction by{20, 60, 140};
      const auto done = kernels::subtract_in_block(cells.data(), masks.data(), by);
      const auto reference = kernels::reference::subtract_in_block(expected.data(), masks.data(), by);
      expect_same(done, reference);
      EXPECT_EQ(done.num_asked, reference.num_asked);
      ASSERT_EQ(cells, expected);
    }
  });
}

TEST(MaskedBytes, CellsAboveAThresholdEqualTheReference) {
  std::mt19937_64 rng(6);
  for (int trial = 0; trial < 100; ++trial) {
    const Cells cells = random_cells(&rng);
    for (const int limit : {0, 1, 41, 127, 128, 200, 255, 256, 1000}) {
      const std::uint64_t bits = kernels::bits_at_least(cells.data(), limit);
      ASSERT_EQ(bits, kernels::reference::bits_at_least(cells.data(), limit)) << limit;
      for (std::size_t i = 0; i < 64; ++i) ASSERT_EQ((bits >> i) & 1u, cells[i] >= limit ? 1u : 0u);
    }
  }
}
