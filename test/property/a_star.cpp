// SPDX-License-Identifier: BSD-3-Clause
#include "voxnav/planning/a_star.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <map>
#include <random>
#include <set>

#include "box_grid.hpp"
#include "planning/segment_box.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;

namespace {

constexpr int kSide = 18;

std::shared_ptr<containers::StateGrid> random_grid(std::mt19937* rng, int percent) {
  auto grid = test::box_grid({0, 0, 0}, {kSide - 1, kSide - 1, kSide - 1});
  for (int i = 0; i < kSide * kSide * kSide * percent / 100; ++i) {
    const auto coordinate = [&] { return static_cast<int>((*rng)() % kSide); };
    grid->set({coordinate(), coordinate(), coordinate()}, VoxelState::kOccupied);
  }
  return grid;
}

bool is_free(const containers::StateGrid& grid, const Index3& voxel) { return grid.state(voxel) == VoxelState::kFree; }

bool is_clear(const containers::StateGrid& grid, const Index3& from, const Index3& step) {
  for (int corner = 1; corner < 8; ++corner) {
    const Index3 part{(corner & 1) ? step.x : 0, (corner & 2) ? step.y : 0, (corner & 4) ? step.z : 0};
    if (!is_free(grid, from + part)) return false;
  }
  return true;
}

/// Returns the cost that Dijkstra's algorithm finds, or infinity if the goal cannot be reached.
double dijkstra(const containers::StateGrid& grid, const Index3& start, const Index3& goal) {
  std::map<Index3, double> cost = {{start, 0.0}};
  std::set<std::pair<double, Index3>> open = {{0.0, start}};
  while (!open.empty()) {
    const auto [length, voxel] = *open.begin();
    open.erase(open.begin());
    if (voxel == goal) return length;
    for (int move = 0; move < 27; ++move) {
      const Index3 step{move % 3 - 1, move / 3 % 3 - 1, move / 9 - 1};
      if (move == 13 || !is_clear(grid, voxel, step)) continue;
      const double next = length + std::sqrt(std::abs(step.x) + std::abs(step.y) + std::abs(step.z));
      const auto it = cost.find(voxel + step);
      if (it != cost.end() && it->second <= next) continue;
      if (it != cost.end()) open.erase({it->second, voxel + step});
      cost[voxel + step] = next;
      open.insert({next, voxel + step});
    }
  }
  return std::numeric_limits<double>::infinity();
}

std::set<Index3> reachable(const containers::StateGrid& grid, const Index3& start) {
  std::set<Index3> out = {start};
  std::vector<Index3> open = {start};
  while (!open.empty()) {
    const Index3 voxel = open.back();
    open.pop_back();
    for (int move = 0; move < 27; ++move) {
      const Index3 step{move % 3 - 1, move / 3 % 3 - 1, move / 9 - 1};
      if (move == 13 || !is_clear(grid, voxel, step)) continue;
      if (out.insert(voxel + step).second) open.push_back(voxel + step);
    }
  }
  return out;
}

Index3 random_free(const containers::StateGrid& grid, std::mt19937* rng) {
  for (;;) {
    const auto coordinate = [&] { return static_cast<int>((*rng)() % kSide); };
    const Index3 voxel{coordinate(), coordinate(), coordinate()};
    if (is_free(grid, voxel)) return voxel;
  }
}

}  // namespace

TEST(AStarProperty, CostEqualsDijkstraOnRandomGrids) {
  planning::AStarConfig config;
  config.safety_distance_m = 0.0;
  config.timeout_s = 30.0;
  const planning::AStarPlanner planner(config);
  int num_blocked = 0;
  for (int seed = 0; seed < 60; ++seed) {
    std::mt19937 rng(static_cast<unsigned>(seed));
    const auto grid = random_grid(&rng, 40 + seed);
    const Index3 start = random_free(*grid, &rng), goal = random_free(*grid, &rng);
    const double expected = dijkstra(*grid, start, goal);
    const auto result =
        planner.plan(planning::StateGridView(grid), geometry::center_of(start, 1.0), geometry::center_of(goal, 1.0));
    if (std::isfinite(expected)) {
      ASSERT_EQ(result.status, planning::PlanStatus::kComplete) << "seed " << seed;
      ASSERT_NEAR(result.cost_m, expected, 1e-6) << "seed " << seed;
      ASSERT_NEAR(planning::length_of(result.path), expected, 1e-6) << "seed " << seed;
    } else {
      ++num_blocked;
      ASSERT_TRUE(result.status == planning::PlanStatus::kPartialBlocked ||
                  result.status == planning::PlanStatus::kNoPath)
          << "seed " << seed;
    }
    for (std::size_t i = 1; i < result.path.size(); ++i) {
      const Index3 from = geometry::index_of(result.path[i - 1], 1.0);
      ASSERT_TRUE(is_clear(*grid, from, geometry::index_of(result.path[i], 1.0) - from)) << "seed " << seed;
    }
  }
  EXPECT_GT(num_blocked, 2) << "the grids must also hold queries without a way";
}

TEST(AStarProperty, AWeightedSearchCostsAtMostTheWeightTimesTheOptimum) {
  for (const double weight : {1.0, 1.2, 2.0, 5.0}) {
    planning::AStarConfig config;
    config.safety_distance_m = 0.0;
    config.timeout_s = 30.0;
    config.heuristic_weight = weight;
    const planning::AStarPlanner planner(config);
    for (int seed = 200; seed < 240; ++seed) {
      std::mt19937 rng(static_cast<unsigned>(seed));
      const auto grid = random_grid(&rng, 10 + seed % 60);
      const Index3 start = random_free(*grid, &rng), goal = random_free(*grid, &rng);
      const double cheapest = dijkstra(*grid, start, goal);
      const auto result =
          planner.plan(planning::StateGridView(grid), geometry::center_of(start, 1.0), geometry::center_of(goal, 1.0));
      if (!std::isfinite(cheapest)) continue;
      ASSERT_EQ(result.status, planning::PlanStatus::kComplete) << "seed " << seed;
      ASSERT_LE(result.cost_m, weight * cheapest + 1e-6) << "seed " << seed << ", weight " << weight;
      ASSERT_GE(result.cost_m, cheapest - 1e-6) << "seed " << seed << ", weight " << weight;
      ASSERT_NEAR(planning::length_of(result.path), result.cost_m, 1e-6) << "seed " << seed << ", weight " << weight;
    }
  }
}

TEST(AStarProperty, AWeightedSearchExpandsNoCellTwice) {
  for (const double weight : {1.0, 1.5, 5.0}) {
    for (int seed = 300; seed < 310; ++seed) {
      std::mt19937 rng(static_cast<unsigned>(seed));
      const auto grid = random_grid(&rng, 30);
      // The goal is enclosed, so that every cell that can be reached is expanded.
      const Index3 goal{kSide - 3, kSide - 3, kSide - 3};
      for (int move = 0; move < 27; ++move) {
        const Index3 step{move % 3 - 1, move / 3 % 3 - 1, move / 9 - 1};
        grid->set(goal + step, move == 13 ? VoxelState::kFree : VoxelState::kOccupied);
      }
      grid->set({0, 0, 0}, VoxelState::kFree);
      planning::AStarConfig config;
      config.safety_distance_m = 0.0;
      config.timeout_s = 30.0;
      config.heuristic_weight = weight;
      const auto result = planning::AStarPlanner(config).plan(planning::StateGridView(grid), Vec3::Constant(0.5),
                                                              geometry::center_of(goal, 1.0));
      ASSERT_TRUE(result.status == planning::PlanStatus::kPartialBlocked ||
                  result.status == planning::PlanStatus::kNoPath)
          << "seed " << seed;
      ASSERT_EQ(result.expansions, reachable(*grid, {0, 0, 0}).size()) << "seed " << seed << ", weight " << weight;
    }
  }
}

TEST(AStarProperty, EveryEdgeKeepsTheSafetyDistanceFromEveryOccupiedVoxel) {
  int num_complete = 0;
  for (int seed = 100; seed < 140; ++seed) {
    std::mt19937 rng(static_cast<unsigned>(seed));
    const auto grid = test::box_grid({0, 0, 0}, {63, 63, 31}, 0.4);
    std::vector<geometry::Aabb> boxes;
    for (int i = 0; i < 40; ++i) {
      const Index3 voxel{static_cast<int>(rng() % 64), static_cast<int>(rng() % 64), static_cast<int>(rng() % 32)};
      grid->set(voxel, VoxelState::kOccupied);
      const Vec3 corner = Vec3(voxel.x, voxel.y, voxel.z) * 0.4;
      boxes.push_back({corner, corner + Vec3::Constant(0.4)});
    }
    planning::AStarConfig config;
    config.safety_distance_m = 0.5 + 0.05 * (seed % 20);
    config.timeout_s = 30.0;
    config.escape_distance_m = 0.0;
    config.simplify = seed % 2 == 0;
    const auto result =
        planning::AStarPlanner(config).plan(planning::StateGridView(grid), {2.2, 2.2, 6.2}, {23.4, 22.2, 7.0});
    num_complete += result.status == planning::PlanStatus::kComplete;
    for (std::size_t i = 1; i < result.path.size(); ++i) {
      for (const geometry::Aabb& box : boxes) {
        const planning::Segment piece{result.path[i - 1], result.path[i]};
        ASSERT_GE(std::sqrt(planning::squared_distance(piece, box)), config.safety_distance_m - 1e-4)
            << "seed " << seed;
      }
    }
  }
  EXPECT_GT(num_complete, 20);
}
