// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "kernels/column_rows.hpp"

using namespace voxnav;  // NOLINT: test

namespace {

template <class Word>
std::vector<Word> random_words(std::mt19937* rng, std::size_t n) {
  std::vector<Word> out(n);
  for (Word& word : out) word = static_cast<Word>((*rng)());
  return out;
}

}  // namespace

TEST(ColumnRows, AddedRowsEqualTheReference) {
  test::with_every_instruction_set([] {
    std::mt19937 rng(1);
    const auto block = random_words<std::uint16_t>(&rng, 256);
    for (int up = -15; up <= 31; ++up) {
      for (const int count : {0, 1, 7, 16}) {
        auto window = random_words<std::uint32_t>(&rng, std::size_t{48} * 16);
        for (auto& column : window) column &= 0x11111111u;
        auto expected = window;
        kernels::add_rows({block.data(), window.data() + 16, 48, count, up});
        kernels::reference::add_rows({block.data(), expected.data() + 16, 48, count, up});
        ASSERT_EQ(window, expected) << up;
      }
    }
  });
}

TEST(ColumnRows, TurnedColumnsEqualTheReference) {
  constexpr int kRowLength = 48, kShift = 25;
  test::with_every_instruction_set([] {
    std::mt19937 rng(2);
    const auto window = random_words<std::uint32_t>(&rng, std::size_t{kRowLength} * 40);
    const auto fixed = [](double edges) { return static_cast<std::int32_t>(std::lround(std::ldexp(edges, kShift))); };
    for (int trial = 0; trial < 200; ++trial) {
      const double angle = 0.05 * trial, c = std::cos(angle), s = std::sin(angle);
      // The block is rotated about its middle, which stays in place.
      const kernels::TurnedBlock at{{fixed(20.3 - 7.5 * (c - s)), fixed(18.7 - 7.5 * (s + c))},
                                    {fixed(c), fixed(s)},
                                    {fixed(-s), fixed(c)},
                                    kShift,
                                    static_cast<unsigned>(trial % 16)};
      auto block = random_words<std::uint16_t>(&rng, 256);
      for (auto& column : block) column &= 0x1111u;
      auto expected = block;
      kernels::add_turned_columns(window.data(), kRowLength, at, block.data());
      kernels::reference::add_turned_columns(window.data(), kRowLength, at, expected.data());
      ASSERT_EQ(block, expected) << angle;
    }
  });
}
