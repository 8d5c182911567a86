// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/path_planner.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "box_grid.hpp"
#include "planning/path/segment_clearance.hpp"
#include "planning/segment_box.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;
using planning::PlanStatus;
using planning::UnknownPolicy;

namespace {

constexpr double kResolution = 0.5;
constexpr double kSafety = 0.7;

/// A building site of 20 x 20 x 8 m: posts, beams, slabs with holes, rubble, and corners of which nothing is known.
class Site {
 public:
  explicit Site(int seed) : rng_(static_cast<unsigned>(seed)) {
    grid = test::box_grid({0, 0, 0}, {39, 39, 15}, kResolution);
    for (int i = 0; i < 12; ++i) {
      const Index3 at = voxel();
      test::fill(grid.get(), {at.x, at.y, 0}, {at.x, at.y, 15}, VoxelState::kOccupied);
    }
    for (int i = 0; i < 4; ++i) {
      const Index3 at = voxel();
      test::fill(grid.get(), {0, at.y, at.z}, {39, at.y, at.z}, VoxelState::kOccupied);
      const int x = voxel().x;
      test::fill(grid.get(), {x, 0, 0}, {x, 39, 15}, i < 2 ? VoxelState::kOccupied : VoxelState::kFree);
      for (int hole = 0; hole < 2; ++hole) {
        const Index3 in = voxel();
        test::fill(grid.get(), {x, in.y, in.z / 2}, {x, in.y + 4, in.z / 2 + 5}, VoxelState::kFree);
      }
    }
    for (int i = 0; i < 30; ++i) grid->set(voxel(), VoxelState::kOccupied);
    if (seed % 7 == 6) test::fill(grid.get(), {19, 0, 0}, {19, 39, 15}, VoxelState::kOccupied);
    for (int i = 0; i < 3; ++i) {
      const Index3 at = voxel();
      test::fill(grid.get(), at, at + Index3{5, 5, 5}, VoxelState::kUnknown);
    }
  }

  Vec3 point() {
    std::uniform_real_distribution<double> share(0.0, 1.0);
    return {20.0 * share(rng_), 20.0 * share(rng_), 8.0 * share(rng_)};
  }
  /// The centre of a flyable cell, where paths over the lattice may begin and end as well.
  Vec3 flyable_point(const planning::ClearanceField& field) {
    for (;;) {
      Vec3 p = geometry::center_of(geometry::index_of(point(), kResolution), kResolution);
      if (field.component(p) != 0) return p;
    }
  }

  std::shared_ptr<containers::StateGrid> grid;

 private:
  Index3 voxel() {
    const auto number = [&](unsigned below) { return static_cast<int>(rng_() % below); };
    const int x = number(40), y = number(40);
    return {x, y, number(16)};
  }
  std::mt19937 rng_;
};

double least_clearance(const containers::StateGrid& grid, const std::vector<Vec3>& path) {
  double least = std::numeric_limits<double>::infinity();
  for (const Index3& block : grid.sorted_block_indices()) {
    for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
      const Index3 voxel = geometry::voxel_at(block, offset);
      if (grid.state(voxel) != VoxelState::kOccupied) continue;
      const Vec3 low = Vec3(voxel.x, voxel.y, voxel.z) * kResolution;
      const geometry::Aabb box{low, low + Vec3::Constant(kResolution)};
      for (std::size_t i = 1; i < path.size(); ++i) {
        least = std::min(least, std::sqrt(planning::squared_distance(planning::Segment{path[i - 1], path[i]}, box)));
      }
    }
  }
  return least;
}

planning::ClearanceField field_of(const Site& site, bool unknown_is_flyable) {
  planning::ClearanceFieldConfig config;
  config.safety_distance_m = kSafety;
  config.radius_m = 2.0;
  config.unknown_is_flyable = unknown_is_flyable;
  planning::ClearanceField field(config);
  field.update(planning::StateGridView(site.grid));
  return field;
}

planning::PathPlannerConfig config_of(int kind) {
  planning::PathPlannerConfig config;
  config.goal_search_radius_m = 0.0;
  config.escape_distance_m = 0.0;
  config.quick = kind >= 6;
  config.suboptimality_bound = config.quick ? 1.2 : 1.05;
  config.clearance_distance_m = kind % 2 == 0 ? 0.0 : 2.0;
  if (kind % 6 >= 2) config.unknown_policy = UnknownPolicy::kPenalise;
  if (kind % 6 >= 4) {
    config.unknown_policy = UnknownPolicy::kOptimisticFar;
    config.optimistic_range_m = 5.0;
    config.known_distance_m = 0.9;
  }
  return config;
}

/// The lattice search with the same costs, without a weight.
planning::PlanResult oracle(const Site& site, const planning::PathPlannerConfig& like, const Vec3& start,
                            const Vec3& goal) {
  planning::AStarConfig config;
  config.max_expansions = 10000000;
  config.timeout_s = 60.0;
  config.safety_distance_m = kSafety;
  config.clearance_distance_m = like.clearance_distance_m;
  config.clearance_weight = like.clearance_weight;
  config.unknown_policy = like.unknown_policy;
  config.unknown_cost = like.unknown_cost;
  config.optimistic_range_m = like.optimistic_range_m;
  config.known_distance_m = like.known_distance_m;
  config.near_unknown_weight = like.near_unknown_weight;
  config.goal_search_radius_m = 0.0;
  config.escape_distance_m = 0.0;
  return planning::AStarPlanner(config).plan(planning::StateGridView(site.grid), start, goal);
}

bool touches_only_known(const containers::StateGrid& grid, const std::vector<Vec3>& path) {
  for (std::size_t i = 1; i < path.size(); ++i) {
    for (int k = 0; k <= 1000; ++k) {
      const Vec3 p = path[i - 1] + (path[i] - path[i - 1]) * (k / 1000.0);
      if (grid.state(geometry::index_of(p, kResolution)) != VoxelState::kFree) return false;
    }
  }
  return true;
}

}  // namespace

TEST(PathPlannerProperty, PathsKeepTheDistanceAndStayNearTheLowerBound) {
  int num_paths = 0, num_blocked = 0;
  for (int seed = 0; seed < 240; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    Site site(seed);
    const planning::PathPlannerConfig config = config_of(seed % 12);
    const planning::ClearanceField field = field_of(site, config.unknown_policy != UnknownPolicy::kForbid);
    const Vec3 start = site.flyable_point(field), goal = site.flyable_point(field);
    const auto plan = planning::PathPlanner(config).plan(field, start, goal);
    const auto lattice = oracle(site, config, start, goal);
    if (lattice.status != PlanStatus::kComplete) {
      ++num_blocked;
      ASSERT_NE(plan.status, PlanStatus::kComplete) << explain(lattice.status);
      continue;
    }
    ASSERT_EQ(plan.status, PlanStatus::kComplete) << explain(plan.status);
    ++num_paths;
    ASSERT_LE(plan.lower_bound_m, lattice.cost_m + 1e-6);
    ASSERT_EQ(plan.path.front(), start);
    ASSERT_LT((plan.path.back() - goal).norm(), 1e-9);
    ASSERT_GE(least_clearance(*site.grid, plan.path), kSafety - 1e-6);
    if (config.unknown_policy == UnknownPolicy::kForbid) {
      ASSERT_TRUE(touches_only_known(*site.grid, plan.path));
      if (config.clearance_distance_m == 0.0) {
        ASSERT_NEAR(plan.cost_m, plan.length_m, 1e-9);
      }
    }
    ASSERT_GE(plan.cost_m, plan.length_m - 1e-9);
    ASSERT_LE(plan.cost_m, config.suboptimality_bound * lattice.cost_m + 1e-6);
  }
  EXPECT_GT(num_paths, 200);
  EXPECT_GT(num_blocked, 4);
}

TEST(PathPlannerProperty, TheSamePathAgain) {
  for (int seed = 0; seed < 6; ++seed) {
    Site site(seed);
    const planning::ClearanceField field = field_of(site, false);
    const Vec3 start = site.flyable_point(field), goal = site.flyable_point(field);
    const planning::PathPlanner planner(config_of(1));
    const auto first = planner.plan(field, start, goal), second = planner.plan(field, start, goal);
    ASSERT_EQ(first.path.size(), second.path.size());
    for (std::size_t i = 0; i < first.path.size(); ++i) ASSERT_EQ(first.path[i], second.path[i]);
    ASSERT_EQ(first.expansions, second.expansions);
  }
}

TEST(PathPlannerProperty, SegmentsAgainstBoxes) {
  std::mt19937 rng(3);
  std::uniform_real_distribution<double> coordinate(-3.0, 4.0);
  const auto point = [&] { return Vec3(coordinate(rng), coordinate(rng), coordinate(rng)); };
  int num_near = 0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 a = point(), b = i % 5 == 0 ? Vec3(a.x(), a.y(), coordinate(rng)) : point();
    const geometry::Aabb box{Vec3(0, 0, 0), Vec3(1, 1, 1 + i % 4)};
    const double distance = 0.25 + 0.5 * (i % 3), exact = std::sqrt(squared_distance(planning::Segment{a, b}, box));
    if (std::abs(exact - distance) < 1e-6) continue;
    num_near += exact < distance;
    ASSERT_EQ(planning::is_nearer(a, b, box, distance), exact < distance) << i;
  }
  EXPECT_GT(num_near, 4000);
}
