// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "box_grid.hpp"
#include "planning/segment_box.hpp"
#include "voxnav/planning/corridor.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using planning::check_corridor;
using planning::CorridorRule;

TEST(SegmentBox, EqualsDenseSampling) {
  std::mt19937 rng(11);
  std::uniform_real_distribution<double> uniform(-3.0, 3.0);
  const auto random_point = [&] { return Vec3(uniform(rng), uniform(rng), uniform(rng)); };
  for (int i = 0; i < 500; ++i) {
    const planning::Segment segment{random_point(), random_point()};
    geometry::Aabb box;
    box.extend(random_point());
    box.extend(random_point());
    double best = 1e9, first = -1.0;
    for (int k = 0; k <= 2000; ++k) {
      const double d = planning::squared_distance(segment.at(k / 2000.0), box);
      best = std::min(best, d);
      if (first < 0.0 && d < 0.49) first = k / 2000.0;
    }
    EXPECT_NEAR(std::sqrt(planning::squared_distance(segment, box)), std::sqrt(best), 5e-3);
    const double t = planning::first_parameter_within(segment, box, 0.7);
    if (first >= 0.0) {
      EXPECT_NEAR(t, first, 1.0 / 2000.0 + 1e-9);
    } else if (t >= 0.0) {
      EXPECT_NEAR(std::sqrt(best), 0.7, 5e-3) << "only a touch between two samples may be missed";
    }
  }
}

TEST(Corridor, FindsTheFirstTouchOfAWallExactly) {
  const auto grid = test::box_grid({-20, -20, -20}, {100, 20, 20}, 0.4);
  test::fill(grid.get(), {60, -20, -20}, {60, 20, 20}, VoxelState::kOccupied);
  const planning::StateGridView view(grid);
  const auto result = check_corridor(view, {{0, 0, 0}, {10, 0, 0}, {30, 0, 0}}, 0.8);
  EXPECT_FALSE(result.is_safe);
  EXPECT_NEAR(result.first_unsafe_m, 60 * 0.4 - 0.8, 1e-6);
  EXPECT_EQ(result.unsafe_state, VoxelState::kOccupied);
  EXPECT_DOUBLE_EQ(result.length_m, 30.0);
  EXPECT_TRUE(check_corridor(view, {{0, 0, 0}, {23.1, 0, 0}}, 0.8).is_safe);
}

TEST(Corridor, IsThreeDimensional) {
  const auto grid = test::box_grid({-20, -20, -20}, {60, 20, 20}, 0.4);
  grid->set({25, 0, 2}, VoxelState::kOccupied);  // a branch above the path, whose lower face is at 0.8 m
  const planning::StateGridView view(grid);
  EXPECT_FALSE(check_corridor(view, {{0, 0.2, 0}, {20, 0.2, 0}}, 0.81).is_safe);
  EXPECT_TRUE(check_corridor(view, {{0, 0.2, 0}, {20, 0.2, 0}}, 0.79).is_safe);
}

TEST(Corridor, UnknownIsUnsafeInFlightOnly) {
  const auto grid = test::box_grid({-20, -20, -20}, {60, 20, 20}, 0.4);
  grid->set({25, 0, 0}, VoxelState::kUnknown);
  const planning::StateGridView view(grid);
  const auto result = check_corridor(view, {{0, 0, 0}, {20, 0, 0}}, 0.5);
  EXPECT_FALSE(result.is_safe);
  EXPECT_EQ(result.unsafe_state, VoxelState::kUnknown);
  EXPECT_TRUE(check_corridor(view, {{0, 0, 0}, {20, 0, 0}}, 0.5, CorridorRule::kNotOccupied).is_safe);
}

TEST(Corridor, UnusableInputIsUnsafeAtOnce) {
  const planning::StateGridView view(test::box_grid({0, 0, 0}, {9, 9, 9}));
  EXPECT_FALSE(check_corridor(view, {}, 0.5).is_safe);
  EXPECT_FALSE(check_corridor(view, {{5, 5, 5}, {5, std::nan(""), 5}}, 0.5).is_safe);
  EXPECT_FALSE(check_corridor(view, {{5, 5, 5}}, std::nan("")).is_safe);
  EXPECT_TRUE(check_corridor(view, {{5, 5, 5}}, 0.5).is_safe);
  EXPECT_TRUE(check_corridor(view, {{5, 5, 5}, {5, 5, 5}}, 0.0).is_safe);
}

TEST(Corridor, EqualsBruteForceOnRandomGrids) {
  std::mt19937 rng(5);
  std::uniform_real_distribution<double> uniform(2.0, 14.0);
  for (int round = 0; round < 60; ++round) {
    const auto grid = test::box_grid({0, 0, 0}, {31, 31, 31}, 0.5);
    for (int i = 0; i < 60; ++i) {
      grid->set({static_cast<int>(rng() % 32), static_cast<int>(rng() % 32), static_cast<int>(rng() % 32)},
                i % 2 ? VoxelState::kOccupied : VoxelState::kUnknown);
    }
    std::vector<Vec3> line;
    line.reserve(4);
    for (int i = 0; i < 4; ++i) line.emplace_back(uniform(rng), uniform(rng), uniform(rng));
    const double radius = 0.9;
    double expected = -1.0, before = 0.0;
    for (std::size_t i = 0; i + 1 < line.size() && expected < 0.0; ++i) {
      const planning::Segment piece{line[i], line[i + 1]};
      for (int z = 0; z < 32; ++z) {
        for (int y = 0; y < 32; ++y) {
          for (int x = 0; x < 32; ++x) {
            if (grid->state(geometry::Index3{x, y, z}) == VoxelState::kFree) continue;
            const Vec3 corner = Vec3(x, y, z) * 0.5;
            const double t = planning::first_parameter_within(piece, {corner, corner + Vec3::Constant(0.5)}, radius);
            if (t >= 0.0 && (expected < 0.0 || before + t * piece.length() < expected)) {
              expected = before + t * piece.length();
            }
          }
        }
      }
      before += piece.length();
    }
    const auto result = check_corridor(planning::StateGridView(grid), line, radius);
    ASSERT_EQ(result.is_safe, expected < 0.0) << "round " << round;
    if (expected < 0.0) continue;
    ASSERT_NEAR(result.first_unsafe_m, expected, 1e-6) << "round " << round;
  }
}
