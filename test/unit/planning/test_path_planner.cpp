// SPDX-License-Identifier: BSD-3-Clause
// Ends of paths: starts that must be left, goals that cannot be reached, and what is answered for them.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "box_grid.hpp"
#include "voxnav/planning/path_planner.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using planning::PathPlannerConfig;
using planning::PlanStatus;
using planning::UnknownPolicy;

namespace {

planning::AnyAnglePlan plan(const std::shared_ptr<containers::StateGrid>& grid, const PathPlannerConfig& config,
                            const Vec3& start, const Vec3& goal) {
  planning::ClearanceFieldConfig field_config;
  field_config.unknown_is_flyable = config.unknown_policy != UnknownPolicy::kForbid;
  field_config.safety_distance_m = 2.0;
  field_config.radius_m = 4.0;
  planning::ClearanceField field(field_config);
  field.update(planning::StateGridView(grid));
  return planning::PathPlanner(config).plan(field, start, goal);
}

PathPlannerConfig optimistic() {
  PathPlannerConfig config;
  config.unknown_policy = UnknownPolicy::kOptimisticFar;
  return config;
}

}  // namespace

TEST(PathPlanner, StartTooNearToAnObstacleIsLeftWithoutTouchingIt) {
  const auto grid = test::box_grid({0, 0, 0}, {40, 20, 20});
  test::fill(grid.get(), {0, 0, 0}, {40, 4, 20}, VoxelState::kOccupied);
  PathPlannerConfig config;
  const Vec3 start(20.3, 5.2, 10.4), goal(35.5, 15.5, 10.5);
  const auto result = plan(grid, config, start, goal);
  EXPECT_EQ(result.status, PlanStatus::kComplete);
  EXPECT_EQ(result.path.front(), start);
  EXPECT_EQ(result.path.back(), goal);
  for (std::size_t i = 0; i < result.path.size(); ++i) EXPECT_GE(result.path[i].y(), i == 0 ? 5.0 : 6.0);
  EXPECT_GE(result.cost_m, result.length_m - 1e-9);
  config.escape_distance_m = 0.5;
  EXPECT_EQ(plan(grid, config, start, goal).status, PlanStatus::kStartBlocked);
}

TEST(PathPlanner, AnOccupiedStartIsNotLeft) {
  const auto grid = test::box_grid({0, 0, 0}, {40, 20, 20});
  test::fill(grid.get(), {10, 10, 10}, {10, 10, 10}, VoxelState::kOccupied);
  const auto result = plan(grid, {}, {10.5, 10.5, 10.5}, {35.5, 10.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kStartBlocked);
  EXPECT_TRUE(result.path.empty());
}

TEST(PathPlanner, AnEnclosedGoalIsKnownWithoutASearch) {
  const auto grid = test::box_grid({0, 0, 0}, {63, 63, 31});
  test::fill(grid.get(), {30, 20, 5}, {50, 40, 25}, VoxelState::kOccupied);
  test::fill(grid.get(), {32, 22, 7}, {48, 38, 23}, VoxelState::kFree);
  for (const auto& config : {PathPlannerConfig{}, optimistic()}) {
    const auto result = plan(grid, config, {5.5, 5.5, 5.5}, {40.5, 30.5, 15.5});
    EXPECT_EQ(result.status, PlanStatus::kGoalEnclosed) << explain(result.status);
    EXPECT_TRUE(result.path.empty()) << "nothing within goal_search_radius_m can be reached";
    EXPECT_EQ(result.expansions, 0u);
    EXPECT_TRUE(std::isinf(result.lower_bound_m));
  }
}

TEST(PathPlanner, ABlockedGoalLeadsToTheNearestCellOutside) {
  const auto grid = test::box_grid({0, 0, 0}, {63, 63, 31});
  test::fill(grid.get(), {40, 20, 0}, {41, 21, 31}, VoxelState::kOccupied);
  const auto result = plan(grid, {}, {5.5, 20.5, 15.5}, {40.5, 20.5, 15.5});
  EXPECT_EQ(result.status, PlanStatus::kGoalBlocked);
  EXPECT_TRUE(result.is_partial);
  EXPECT_NEAR(result.remaining_m, std::sqrt(8.0), 1e-9) << "two cells away on both axes, 2.1 m from the box";
}

TEST(PathPlanner, AnUnknownGoalThatAnObstacleBlocksIsBlockedWhateverIsBehind) {
  const auto grid = test::box_grid({0, 0, 0}, {40, 20, 20});
  test::fill(grid.get(), {30, 0, 0}, {30, 20, 20}, VoxelState::kOccupied);
  test::fill(grid.get(), {31, 0, 0}, {40, 20, 20}, VoxelState::kUnknown);
  for (const auto& config : {PathPlannerConfig{}, optimistic()}) {
    const auto result = plan(grid, config, {5.5, 10.5, 10.5}, {31.5, 10.5, 10.5});
    EXPECT_EQ(result.status, PlanStatus::kGoalBlocked) << explain(result.status);
    ASSERT_FALSE(result.path.empty());
    EXPECT_NEAR(std::abs(result.path.back().x() - 30.5), 3.0, 1e-9) << "the nearest place with 2 m to the wall";
  }
  const auto behind = plan(grid, PathPlannerConfig{}, {5.5, 10.5, 10.5}, {35.5, 10.5, 10.5});
  EXPECT_EQ(behind.status, PlanStatus::kGoalUnknown) << explain(behind.status);
}

TEST(PathPlanner, AGoalOutsideTheMapIsApproachedAsFarAsTheMapGoes) {
  const auto grid = test::box_grid({0, 0, 0}, {63, 63, 31});
  test::fill(grid.get(), {55, 10, 0}, {63, 50, 31}, VoxelState::kOccupied);
  const auto result = plan(grid, {}, {5.5, 30.5, 15.5}, {1000.0, 30.5, 15.5});
  EXPECT_EQ(result.status, PlanStatus::kOutsideMap);
  ASSERT_FALSE(result.path.empty());
  EXPECT_GT(result.path.back().x(), 45.0);
}

TEST(PathPlanner, AnUnknownGoalBelowTheGroundIsNamed) {
  const auto grid = std::make_shared<containers::StateGrid>(1.0);
  test::fill(grid.get(), {0, 0, 20}, {63, 63, 40}, VoxelState::kFree);
  test::fill(grid.get(), {0, 0, 19}, {63, 63, 19}, VoxelState::kOccupied);
  const Vec3 start(5.5, 5.5, 30.5);
  EXPECT_EQ(plan(grid, optimistic(), start, {32.5, 32.5, 17.5}).status, PlanStatus::kGoalBelowGround);
  // A crate of 8 m stands on the ground: what is in it may have a door.
  test::fill(grid.get(), {28, 28, 20}, {36, 36, 28}, VoxelState::kUnknown);
  test::fill(grid.get(), {28, 28, 29}, {36, 36, 29}, VoxelState::kOccupied);
  EXPECT_NE(plan(grid, optimistic(), start, {32.5, 32.5, 24.5}).status, PlanStatus::kGoalBelowGround);
  EXPECT_EQ(plan(grid, optimistic(), start, {32.5, 32.5, 17.5}).status, PlanStatus::kGoalBelowGround);
}

TEST(PathPlanner, AQuickPathKeepsItsBoundOrIsLeftToTheThoroughSearch) {
  // A wall with one gap high up: changes of height cost nothing to the search that makes the bound.
  const auto grid = test::box_grid({0, 0, 0}, {63, 31, 47});
  test::fill(grid.get(), {30, 0, 0}, {31, 31, 34}, VoxelState::kOccupied);
  PathPlannerConfig config;
  const Vec3 start(5.5, 15.5, 5.5), goal(58.5, 15.5, 5.5);
  const auto thorough = plan(grid, config, start, goal);
  config.quick = true;
  config.suboptimality_bound = 1.2;
  const auto quick = plan(grid, config, start, goal);
  ASSERT_EQ(quick.status, PlanStatus::kComplete);
  EXPECT_LE(quick.cost_m, 1.2 * thorough.cost_m + 1e-9);
  EXPECT_TRUE(std::isfinite(quick.cost_m));
}

TEST(PathPlanner, AQuickSearchExpandsFewerRunsInADenseForest) {
  // Trunks of one column, in whose shadows the straight line to the goal leads nowhere.
  const auto grid = test::box_grid({0, 0, 0}, {127, 127, 15});
  std::mt19937 rng(5);
  for (int i = 0; i < 150; ++i) {
    const int x = 10 + static_cast<int>(rng() % 108u), y = static_cast<int>(rng() % 128u);
    test::fill(grid.get(), {x, y, 0}, {x, y, 15}, VoxelState::kOccupied);
  }
  PathPlannerConfig config;
  config.clearance_distance_m = 4.0;
  int num_paths = 0;
  for (int i = 0; i < 12; ++i) {
    const Vec3 start(3.5, 5.5 + 10.0 * i, 8.5), goal(124.5, 125.5 - 10.0 * i, 8.5);
    config.quick = false;
    config.suboptimality_bound = 1.05;
    const auto thorough = plan(grid, config, start, goal);
    if (thorough.status != PlanStatus::kComplete) continue;
    config.quick = true;
    config.suboptimality_bound = 1.2;
    const auto quick = plan(grid, config, start, goal);
    ASSERT_EQ(quick.status, PlanStatus::kComplete);
    EXPECT_LE(quick.cost_m, 1.2 * thorough.cost_m);
    EXPECT_LT(quick.expansions, thorough.expansions) << i;
    ++num_paths;
  }
  EXPECT_GE(num_paths, 8);
}

TEST(PathPlanner, LimitsEndTheSearchAndLeaveAPartialPath) {
  const auto grid = test::box_grid({0, 0, 0}, {127, 127, 31});
  test::fill(grid.get(), {60, 30, 0}, {60, 90, 31}, VoxelState::kOccupied);
  PathPlannerConfig config;
  config.max_expansions = 1000;
  const auto result = plan(grid, config, {5.5, 60.5, 10.5}, {120.5, 60.5, 10.5});
  EXPECT_EQ(result.status, PlanStatus::kPartialLimit);
  EXPECT_TRUE(result.is_partial);
  ASSERT_FALSE(result.path.empty());
  EXPECT_GT(result.path.back().x(), 30.0);
  config.quick = true;
  const auto quick = plan(grid, config, {5.5, 60.5, 10.5}, {120.5, 60.5, 10.5});
  EXPECT_EQ(quick.status, PlanStatus::kPartialLimit);
  ASSERT_FALSE(quick.path.empty()) << "what the quick search spent must not end the thorough one";
  EXPECT_EQ(quick.path.back(), result.path.back());
}
