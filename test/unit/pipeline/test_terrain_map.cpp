// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "box_grid.hpp"
#include "pipeline/opening.hpp"
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
  ASSERT_NE(terrain.column(0, 0), nullptr);
  EXPECT_TRUE(terrain.column(0, 0)->is_known_anywhere());
  EXPECT_EQ(terrain.column(40, 0), nullptr);
  const pipeline::TerrainMap far(*grid, {5000, 0, 0});
  EXPECT_FALSE(far.height_m(10, 10));
  EXPECT_FALSE(pipeline::TerrainMap(containers::StateGrid(0.4), {0, 0, 0}).height_m(0, 0));
  EXPECT_FALSE(pipeline::TerrainMap(*test::box_grid({0, 0, 0}, {9, 9, 9}), {0, 0, 0}).height_m(0, 0));
}

TEST(TerrainMap, IsTheSameWhenItIsMadeOfTheOneBefore) {
  std::mt19937 random(7);
  const auto number = [&](int low, int high) { return low + static_cast<int>(random() % (high - low + 1)); };
  const auto grid = hilly_grid();
  auto terrain = std::make_unique<pipeline::TerrainMap>(*grid, Vec3(30, 10, 10));
  for (int round = 0; round < 30; ++round) {
    const geometry::Index3 corner{number(0, 110), number(0, 36), number(0, 12)};
    const VoxelState state = round % 3 == 0 ? VoxelState::kOccupied : VoxelState::kFree;
    test::fill(grid.get(), corner, corner + geometry::Index3{number(0, 9), number(0, 3), number(0, 20)}, state);
    if (round % 5 == 4) grid->erase_block({number(0, 7), number(0, 2), 0});
    const auto kept = std::make_unique<pipeline::TerrainMap>(*grid, Vec3(30, 10, 10), terrain.get());
    const pipeline::TerrainMap fresh(*grid, {30, 10, 10});
    ASSERT_EQ(kept->columns().size(), fresh.columns().size());
    int num_kept = 0;
    for (const auto& [index, column] : fresh.columns()) {
      const pipeline::TerrainColumn* other = kept->column(index.x, index.y);
      ASSERT_NE(other, nullptr);
      ASSERT_EQ(other->ground(), column->ground()) << index.x << ' ' << index.y;
      num_kept += other == terrain->column(index.x, index.y) ? 1 : 0;
    }
    EXPECT_GT(num_kept, 0);
    *terrain = *kept;
  }
}

TEST(TerrainMap, ForbidsWhatIsOutsideTheLimitsInEachColumn) {
  for (const pipeline::HeightLimits& limits :
       {pipeline::HeightLimits{3, std::nullopt}, pipeline::HeightLimits{std::nullopt, 14},
        pipeline::HeightLimits{3, 14}}) {
    const pipeline::TerrainMap terrain(*hilly_grid(), {30, 10, 10});
    for (const auto& [index, column] : terrain.columns()) {
      for (int z = -2; z < 4; ++z) {
        planning::BlockMask mask;
        const bool is_any = column->forbid(z, limits, &mask);
        EXPECT_EQ(is_any, mask.any());
        for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
          const int height = z * 16 + offset / 256, ground = column->ground()[static_cast<std::size_t>(offset % 256)];
          const bool is_known = ground != pipeline::TerrainColumn::kUnknown;
          const bool is_outside = is_known && ((limits.low && height < ground + *limits.low) ||
                                               (limits.high && height > ground + *limits.high));
          ASSERT_EQ(mask[static_cast<std::size_t>(offset)], is_outside) << height << ' ' << ground;
        }
      }
    }
  }
}

TEST(Opening, IsTheGreatestOfTheLeastHeightsInTheWindow) {
  std::mt19937 random(3);
  constexpr int kSide = 6, kReach = 2, kMargin = 5, kWidth = kSide + 2 * kMargin;
  const auto cell = [](int x, int y, int width) { return static_cast<std::size_t>(y) * width + x; };
  for (int round = 0; round < 20; ++round) {
    std::vector<std::int32_t> cells(cell(0, kWidth, kWidth));
    std::vector<bool> is_set(cells.size());
    pipeline::Opening opening(kSide, kMargin, kReach);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      is_set[i] = random() % 4 != 0;
      cells[i] = is_set[i] && random() % 3 != 0 ? static_cast<int>(random() % 9) : pipeline::Opening::kUnknown;
      const int x = static_cast<int>(i) % kWidth, y = static_cast<int>(i) / kWidth;
      if (is_set[i]) opening.set_row(x - kMargin, y - kMargin, &cells[i], 1);
    }
    const auto window = [&](int x, int y, auto visit) {
      for (int v = std::max(0, y - kReach); v <= std::min(kWidth - 1, y + kReach); ++v) {
        for (int u = std::max(0, x - kReach); u <= std::min(kWidth - 1, x + kReach); ++u) visit(u, v);
      }
    };
    std::vector<std::int32_t> found(cell(0, kSide, kSide));
    opening.run(&found[0]);
    for (int y = 0; y < kSide; ++y) {
      for (int x = 0; x < kSide; ++x) {
        std::int32_t best = INT32_MIN;
        window(x + kMargin, y + kMargin, [&](int u, int v) {
          std::int32_t least = pipeline::Opening::kUnknown;
          window(u, v, [&](int s, int t) { least = std::min(least, cells[cell(s, t, kWidth)]); });
          if (is_set[cell(u, v, kWidth)] && least != pipeline::Opening::kUnknown) {
            best = std::max(best, least);
          }
        });
        EXPECT_EQ(found[cell(x, y, kSide)], best == INT32_MIN ? pipeline::Opening::kUnknown : best);
      }
    }
  }
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
