// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "box_grid.hpp"
#include "voxnav/planning/a_star.hpp"
#include "voxnav/planning/corridor.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using planning::AStarConfig;
using planning::PlanStatus;
using planning::UnknownPolicy;

namespace {

AStarConfig raw_config() {
  AStarConfig config;
  config.safety_distance_m = 0.0;
  config.timeout_s = 60.0;
  return config;
}

planning::PlanResult plan(const std::shared_ptr<containers::StateGrid>& grid, const AStarConfig& config,
                          const Vec3& start, const Vec3& goal) {
  return planning::AStarPlanner(config).plan(planning::StateGridView(grid), start, goal);
}

}  // namespace

TEST(AStar, StraightLineInEmptySpaceExpandsOnlyThePath) {
  const auto grid = test::box_grid({0, 0, 0}, {31, 31, 15});
  const auto result = plan(grid, raw_config(), {0.5, 5.5, 5.5}, {20.5, 5.5, 5.5});
  EXPECT_EQ(result.status, PlanStatus::kComplete);
  EXPECT_FALSE(result.is_partial);
  EXPECT_DOUBLE_EQ(result.cost_m, 20.0);
  EXPECT_EQ(result.path.size(), 21u);
  EXPECT_EQ(result.expansions, 21u) << "ties must go to the larger cost so far";
}

TEST(AStar, DiagonalsDoNotCutCorners) {
  const auto grid = test::box_grid({0, 0, 0}, {2, 2, 0});
  grid->set({1, 0, 0}, VoxelState::kOccupied);
  const auto result = plan(grid, raw_config(), {0.5, 0.5, 0.5}, {1.5, 1.5, 0.5});
  EXPECT_EQ(result.status, PlanStatus::kComplete);
  EXPECT_DOUBLE_EQ(result.cost_m, 2.0);
}

TEST(AStar, SpaceDiagonalNeedsAllEightCells) {
  const auto grid = test::box_grid({0, 0, 0}, {1, 1, 1});
  grid->set({1, 1, 0}, VoxelState::kOccupied);
  const auto result = plan(grid, raw_config(), {0.5, 0.5, 0.5}, {1.5, 1.5, 1.5});
  EXPECT_NEAR(result.cost_m, 1.0 + std::sqrt(2.0), 1e-12);
}

TEST(AStar, UnknownIsForbiddenUnlessThePolicySaysOtherwise) {
  const auto grid = test::box_grid({0, 0, 0}, {20, 4, 4});
  test::fill(grid.get(), {8, 0, 0}, {10, 4, 4}, VoxelState::kUnknown);
  AStarConfig config = raw_config();
  auto result = plan(grid, config, {1.5, 2.5, 2.5}, {18.5, 2.5, 2.5});
  EXPECT_EQ(result.status, PlanStatus::kPartialBlocked);
  EXPECT_DOUBLE_EQ(result.path.back().x(), 7.5);
  config.unknown_policy = UnknownPolicy::kPenalise;
  result = plan(grid, config, {1.5, 2.5, 2.5}, {18.5, 2.5, 2.5});
  EXPECT_EQ(result.status, PlanStatus::kComplete);
  EXPECT_DOUBLE_EQ(result.cost_m, 17.0 + 3.0);  // three unknown cells cost twice as much
  config.unknown_policy = UnknownPolicy::kOptimisticFar;
  config.optimistic_range_m = 5.0;
  EXPECT_EQ(plan(grid, config, {1.5, 2.5, 2.5}, {18.5, 2.5, 2.5}).status, PlanStatus::kComplete);
  config.optimistic_range_m = 8.0;
  EXPECT_EQ(plan(grid, config, {1.5, 2.5, 2.5}, {18.5, 2.5, 2.5}).status, PlanStatus::kPartialBlocked);
}

TEST(AStar, GoalInsideAnObstacleLeadsNearIt) {
  const auto grid = test::box_grid({0, 0, 0}, {40, 20, 20});
  test::fill(grid.get(), {28, 8, 8}, {32, 12, 12}, VoxelState::kOccupied);
  const auto result = plan(grid, raw_config(), {2.5, 10.5, 10.5}, {30.5, 10.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kGoalBlocked);
  EXPECT_TRUE(result.is_partial);
  EXPECT_NEAR(result.remaining_m, 3.0, 1e-9);
}

TEST(AStar, GoalOutsideTheMapLeadsTowardsIt) {
  const auto grid = test::box_grid({0, 0, 0}, {31, 31, 15});
  const auto result = plan(grid, raw_config(), {2.5, 2.5, 2.5}, {500.0, 2.5, 2.5});
  EXPECT_EQ(result.status, PlanStatus::kOutsideMap);
  EXPECT_TRUE(result.is_partial);
  EXPECT_DOUBLE_EQ(result.path.back().x(), 31.5);
}

TEST(AStar, StartIsNamedWhenItCannotBeUsed) {
  const auto grid = test::box_grid({0, 0, 0}, {15, 15, 15});
  grid->set({5, 5, 5}, VoxelState::kOccupied);
  grid->set({9, 9, 9}, VoxelState::kUnknown);
  const Vec3 goal(2.5, 2.5, 2.5);
  EXPECT_EQ(plan(grid, raw_config(), {5.5, 5.5, 5.5}, goal).status, PlanStatus::kStartBlocked);
  EXPECT_EQ(plan(grid, raw_config(), {9.5, 9.5, 9.5}, goal).status, PlanStatus::kStartUnknown);
  EXPECT_EQ(plan(grid, raw_config(), {-9.5, 9.5, 9.5}, goal).status, PlanStatus::kOutsideMap);
  EXPECT_EQ(plan(grid, raw_config(), {std::nan(""), 0, 0}, goal).status, PlanStatus::kInvalidInput);
  EXPECT_EQ(plan(grid, raw_config(), goal, {0, 1e300, 0}).status, PlanStatus::kOutsideMap);
  EXPECT_EQ(plan(grid, raw_config(), {0, 1e300, 0}, goal).status, PlanStatus::kOutsideMap);
}

TEST(AStar, StartTooNearToAnObstacleIsLeftWithoutTouchingIt) {
  const auto grid = test::box_grid({0, 0, 0}, {40, 20, 20});
  test::fill(grid.get(), {0, 0, 0}, {40, 4, 20}, VoxelState::kOccupied);
  AStarConfig config = raw_config();
  config.safety_distance_m = 2.0;
  const auto result = plan(grid, config, {20.5, 5.5, 10.5}, {35.5, 15.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kComplete);
  EXPECT_DOUBLE_EQ(result.path.front().y(), 5.5);
  EXPECT_GE(result.path[2].y(), 7.5);
  config.escape_distance_m = 0.5;
  EXPECT_EQ(plan(grid, config, {20.5, 5.5, 10.5}, {35.5, 15.5, 10.5}).status, PlanStatus::kStartBlocked);
}

TEST(AStar, EveryLimitEndsTheSearchAndLeavesAPartialPath) {
  const auto grid = test::box_grid({0, 0, 0}, {127, 127, 31});
  test::fill(grid.get(), {100, 0, 0}, {100, 127, 31}, VoxelState::kOccupied);
  AStarConfig config = raw_config();
  config.max_expansions = 1000;
  auto result = plan(grid, config, {2.5, 60.5, 10.5}, {120.5, 60.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kPartialLimit);
  EXPECT_LE(result.expansions, 1000u);
  EXPECT_GT(result.path.back().x(), 50.0);
  config = raw_config();
  config.max_memory_mib = 4.0;
  result = plan(grid, config, {2.5, 60.5, 10.5}, {120.5, 60.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kPartialLimit);
  EXPECT_LE(result.memory_bytes, 4u << 20);
  config = raw_config();
  config.timeout_s = 0.001;
  result = plan(grid, config, {2.5, 60.5, 10.5}, {120.5, 60.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kPartialTimeout);
}

TEST(AStar, AnEnclosedGoalIsAnsweredWithinTheLimits) {
  const auto grid = test::box_grid({0, 0, 0}, {63, 63, 31});
  test::fill(grid.get(), {40, 20, 5}, {50, 30, 15}, VoxelState::kOccupied);
  test::fill(grid.get(), {42, 22, 7}, {48, 28, 13}, VoxelState::kFree);
  const auto result = plan(grid, raw_config(), {2.5, 2.5, 2.5}, {45.5, 25.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kPartialBlocked);
  EXPECT_GT(result.path.size(), 10u);
}

TEST(AStar, ClearanceCostKeepsToTheMiddle) {
  const auto grid = test::box_grid({0, 0, 0}, {60, 30, 0});
  test::fill(grid.get(), {10, 0, 0}, {50, 9, 0}, VoxelState::kOccupied);
  test::fill(grid.get(), {10, 19, 0}, {50, 30, 0}, VoxelState::kOccupied);
  AStarConfig config = raw_config();
  config.safety_distance_m = 1.0;
  config.clearance_distance_m = 5.0;
  config.clearance_weight = 5.0;
  const auto result = plan(grid, config, {2.5, 11.5, 0.5}, {58.5, 11.5, 0.5});
  ASSERT_EQ(result.status, PlanStatus::kComplete);
  for (const Vec3& p : result.path) {
    if (p.x() < 20.0 || p.x() > 40.0) continue;
    EXPECT_DOUBLE_EQ(p.y(), 14.5);
  }
}

TEST(AStar, SimplifiedPathIsShorterAndStillClear) {
  const auto grid = test::box_grid({0, 0, 0}, {60, 60, 20});
  test::fill(grid.get(), {20, 0, 0}, {22, 40, 20}, VoxelState::kOccupied);
  AStarConfig config = raw_config();
  config.safety_distance_m = 1.5;
  const auto full = plan(grid, config, {2.5, 2.5, 10.5}, {55.5, 10.5, 12.5});
  config.simplify = true;
  const auto simple = plan(grid, config, {2.5, 2.5, 10.5}, {55.5, 10.5, 12.5});
  ASSERT_EQ(simple.status, PlanStatus::kComplete);
  EXPECT_LT(simple.path.size(), full.path.size() / 4);
  EXPECT_EQ(simple.path.front(), full.path.front());
  EXPECT_EQ(simple.path.back(), full.path.back());
  EXPECT_LT(planning::length_of(simple.path), planning::length_of(full.path));
  const planning::StateGridView view(grid);
  EXPECT_TRUE(planning::check_corridor(view, simple.path, 1.5 - 1e-9, planning::CorridorRule::kNotOccupied).is_safe);
}

TEST(AStar, BadConfigurationIsRefused) {
  AStarConfig config;
  config.unknown_policy = static_cast<UnknownPolicy>(7);
  EXPECT_THROW(planning::AStarPlanner{config}, base::ConfigError);
}
