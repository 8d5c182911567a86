// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "box_grid.hpp"
#include "pipeline/terrain_map.hpp"
#include "voxnav/pipeline/navigation_map.hpp"
#include "voxnav/planning/path_planner.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using planning::PlanStatus;

namespace {

constexpr double kResolution = 0.5;

/// A hill of 6 m between x = 20 and 40 m, with slopes of 45 degrees.
double hill_m(double x) { return std::max(0.0, std::min({x - 20.0, 6.0, 46.0 - x})); }

/// The voxel of the ground's surface in a column.
int ground(int x) { return static_cast<int>(hill_m((x + 0.5) * kResolution) / kResolution); }

/// Ground under 60 x 20 m of free air up to 20 m, with trunks and, where nothing below them is known, crowns.
std::shared_ptr<containers::StateGrid> hilly_grid() {
  auto grid = test::box_grid({0, 0, 0}, {119, 39, 39}, kResolution);
  for (int x = 0; x < 120; ++x) {
    const int top = ground(x);
    for (int y = 0; y < 40; ++y) {
      test::fill(grid.get(), {x, y, -1}, {x, y, top}, VoxelState::kUnknown);
      grid->set({x, y, top}, VoxelState::kOccupied);
    }
  }
  for (int x = 5; x < 120; x += 14) {
    test::fill(grid.get(), {x, 8, ground(x)}, {x, 8, 20}, VoxelState::kOccupied);
    test::fill(grid.get(), {x, 28, 0}, {x + 3, 31, 18}, VoxelState::kUnknown);
    test::fill(grid.get(), {x, 28, 19}, {x + 3, 31, 20}, VoxelState::kOccupied);
  }
  return grid;
}

struct Limits {
  double min_height_m;
  double max_height_m;
};

std::shared_ptr<const planning::OccupancyView> view_of(const Limits& limits, const Vec3& vehicle) {
  pipeline::NavigationMapConfig config;
  config.min_altitude_m = 0.0;
  config.max_altitude_m = 19.0;
  config.min_height_m = limits.min_height_m;
  config.max_height_m = limits.max_height_m;
  pipeline::NavigationMap map(config);
  map.apply_local(containers::snapshot_of(*hilly_grid()), 1, kResolution);
  map.set_T_W_O(geometry::Pose::Identity());
  map.set_vehicle(vehicle);
  return map.view();
}

planning::AnyAnglePlan plan(const Limits& limits, const Vec3& start, const Vec3& goal) {
  planning::ClearanceFieldConfig config;
  config.safety_distance_m = 1.0;
  config.unknown_is_flyable = true;
  planning::ClearanceField field(config);
  field.update(*view_of(limits, start));
  planning::PathPlannerConfig planner;
  planner.unknown_policy = planning::UnknownPolicy::kPenalise;
  planner.unknown_cost = 1.1;
  return planning::PathPlanner(planner).plan(field, start, goal);
}

/// The least and the greatest height of a path above the ground.
Limits heights(const std::vector<Vec3>& path) {
  Limits out{1e9, -1e9};
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (int k = 0; k <= 200; ++k) {
      const Vec3 p = path[i - 1] + (path[i] - path[i - 1]) * (k / 200.0);
      out.min_height_m = std::min(out.min_height_m, p.z() - hill_m(p.x()));
      out.max_height_m = std::max(out.max_height_m, p.z() - hill_m(p.x()));
    }
  }
  return out;
}

}  // namespace

TEST(TerrainMap, IsTheGroundUnderTrunksAndCrowns) {
  const pipeline::TerrainMap terrain(*hilly_grid(), {30, 10, 10});
  for (int x = 0; x < 120; ++x) {
    for (int y = 0; y < 40; ++y) {
      ASSERT_TRUE(terrain.height_m(x, y)) << x << ' ' << y;
      // Its steps are voxels, and the top of the hill is rounded no more than the slope rises in a voxel.
      ASSERT_NEAR(*terrain.height_m(x, y), hill_m((x + 0.5) * kResolution), 2.0 * kResolution) << x << ' ' << y;
    }
  }
}

TEST(TerrainMap, IsNotKnownWhereTheMapShowsNothing) {
  const auto grid = hilly_grid();
  const pipeline::TerrainMap terrain(*grid, {30, 10, 10});
  EXPECT_FALSE(terrain.height_m(500, 10));
  EXPECT_FALSE(terrain.height_m(-500, 10));
  EXPECT_TRUE(terrain.knows_block(0, 0));
  EXPECT_FALSE(terrain.knows_block(40, 0));
  const pipeline::TerrainMap far(*grid, {5000, 0, 0});
  EXPECT_FALSE(far.height_m(10, 10));
  EXPECT_FALSE(pipeline::TerrainMap(containers::StateGrid(0.4), {0, 0, 0}).height_m(0, 0));
  EXPECT_FALSE(pipeline::TerrainMap(*test::box_grid({0, 0, 0}, {9, 9, 9}), {0, 0, 0}).height_m(0, 0));
}

TEST(TerrainMap, PathsKeepTheirHeightsOverAHill) {
  const Vec3 start(5.2, 10.2, 4.2), goal(55.2, 10.2, 4.2);
  const auto free = plan({0.0, 0.0}, start, goal);
  ASSERT_EQ(free.status, PlanStatus::kComplete);
  EXPECT_LT(heights(free.path).min_height_m, 2.5);
  const auto low = plan({0.0, 6.0}, start, goal);
  ASSERT_EQ(low.status, PlanStatus::kComplete) << explain(low.status);
  EXPECT_LE(heights(low.path).max_height_m, 6.0 + 2.0 * kResolution);
  const auto between = plan({3.0, 6.0}, start, goal);
  ASSERT_EQ(between.status, PlanStatus::kComplete) << explain(between.status);
  EXPECT_GE(heights(between.path).min_height_m, 3.0 - 2.0 * kResolution);
  EXPECT_LE(heights(between.path).max_height_m, 6.0 + 2.0 * kResolution);
}

TEST(TerrainMap, AGoalTooHighAboveTheGroundIsBlockedAndTheOneAboveTheHillIsNot) {
  const Vec3 start(5.2, 10.2, 4.2);
  EXPECT_EQ(plan({0.0, 5.0}, start, {12.2, 10.2, 9.2}).status, PlanStatus::kGoalBlocked);
  EXPECT_EQ(plan({0.0, 5.0}, start, {30.2, 10.2, 9.2}).status, PlanStatus::kComplete);
  EXPECT_EQ(plan({5.0, 0.0}, {5.2, 10.2, 6.2}, {12.2, 10.2, 3.2}).status, PlanStatus::kGoalBlocked);
}

TEST(TerrainMap, AVehicleOutsideItsHeightsComesBack) {
  const auto up = plan({5.0, 8.0}, {5.2, 10.2, 1.7}, {12.2, 10.2, 6.2});
  EXPECT_EQ(up.status, PlanStatus::kComplete) << explain(up.status);
  const auto down = plan({2.0, 4.0}, {5.2, 10.2, 12.2}, {12.2, 10.2, 3.2});
  EXPECT_EQ(down.status, PlanStatus::kComplete) << explain(down.status);
}

TEST(TerrainMap, HeightsAreAskedForInOrder) {
  pipeline::NavigationMapConfig config;
  config.min_height_m = 5.0;
  config.max_height_m = 4.0;
  EXPECT_THROW(pipeline::NavigationMap{config}, base::ConfigError);
  config.max_height_m = 0.0;
  pipeline::NavigationMap map(config);
}
