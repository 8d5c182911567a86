// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "kernels/ball_columns.hpp"

using namespace voxnav;  // NOLINT: test

TEST(BallColumns, EqualTheReference) {
  constexpr std::size_t kColumns = std::size_t{kernels::kColumnWindowSide} * kernels::kColumnWindowSide;
  test::with_every_instruction_set([] {
    std::mt19937 rng(1);
    std::uniform_real_distribution<float> place(7.5f, 23.5f);
    for (const float reach : {0.5f, 0.87f, 1.3f, 2.5f, 3.75f, 5.0f, 7.0f}) {
      for (const std::size_t n : {1u, 5u, 100u}) {
        std::vector<kernels::BallCenter> centers(n);
        for (auto& center : centers) center = {place(rng), place(rng), place(rng)};
        centers[0] = {8.0f, 16.0f, 15.5f};  // at the centre of a voxel along some axes, between two along others
        std::vector<std::uint32_t> columns(kColumns), expected(kColumns);
        kernels::add_balls(centers.data(), n, reach * reach, columns.data());
        kernels::reference::add_balls(centers.data(), n, reach * reach, expected.data());
        ASSERT_EQ(columns, expected) << reach;
      }
    }
  });
}
