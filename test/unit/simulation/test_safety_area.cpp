// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav_simulation/estimator_switches.hpp"
#include "voxnav_simulation/safety_area.hpp"

using namespace voxnav_simulation;  // NOLINT: test

namespace {

/// An L: the square of 10 m without its upper right quarter.
SafetyAreaConfig area() {
  SafetyAreaConfig out;
  out.is_enabled = true;
  out.points_m = {0, 0, 10, 0, 10, 5, 5, 5, 5, 10, 0, 10};
  out.min_z_m = 0.5;
  out.max_z_m = 4.0;
  return out;
}

TrackedTrajectory line(const Vec3& from, const Vec3& to, int count) {
  TrackedTrajectory out;
  for (int i = 0; i < count; ++i) out.points.push_back({from + (to - from) * i / (count - 1), 0.0});
  return out;
}

}  // namespace

TEST(SafetyArea, HasThePointsOfItsPrismAndIsEverywhereWithoutOne) {
  for (const Vec3& p : {Vec3(1, 1, 1), Vec3(9, 4, 1), Vec3(4, 9, 3.9)}) EXPECT_TRUE(is_inside(area(), p)) << p;
  for (const Vec3& p : {Vec3(9, 9, 1), Vec3(-1, 1, 1), Vec3(1, 11, 1), Vec3(1, 1, 0.4), Vec3(1, 1, 4.1)}) {
    EXPECT_FALSE(is_inside(area(), p)) << p;
    EXPECT_TRUE(is_inside(SafetyAreaConfig(), p));
  }
}

TEST(SafetyArea, HasStraightWaysThatLeaveItNowhere) {
  const auto all = SafetyLimits::kBorderAndHeights, border = SafetyLimits::kBorder;
  EXPECT_TRUE(is_way_inside(area(), {1, 1, 1}, {9, 1, 1}, all));
  EXPECT_FALSE(is_way_inside(area(), {4, 9, 1}, {9, 4, 1}, all));  // both ends are inside, the corner is between them
  EXPECT_FALSE(is_way_inside(area(), {1, 1, 1}, {11, 1, 1}, all));
  EXPECT_FALSE(is_way_inside(area(), {1, 1, 1}, {9, 1, 5}, all));
  EXPECT_TRUE(is_way_inside(area(), {1, 1, 1}, {9, 1, 5}, border));
  EXPECT_TRUE(is_way_inside(SafetyAreaConfig(), {1, 1, 1}, {99, 1, 1}, all));
  EXPECT_TRUE(is_inside(area(), {1, 1, 9}, border));
  EXPECT_FALSE(is_inside(area(), {9, 9, 1}, border));
}

TEST(SafetyArea, CutsTheTailFromTheFirstPointOutsideOn) {
  TrackedTrajectory across = line({4, 7, 1}, {4, 7, 1}, 1);
  across = line({1, 7, 1}, {9, 7, 1}, 9);
  const SafetyVerdict verdict = keep_inside(area(), &across);
  EXPECT_TRUE(verdict.is_modified && verdict.refusal.empty());
  ASSERT_EQ(across.points.size(), 4U);
  EXPECT_EQ(across.points.back().position, Vec3(4, 7, 1));
  // What comes back into the area is cut off as well.
  TrackedTrajectory returning = line({4, 7, 1}, {8, 7, 1}, 5);
  returning.points.push_back({Vec3(8, 4, 1), 0.0});
  EXPECT_TRUE(keep_inside(area(), &returning).is_modified);
  EXPECT_EQ(returning.points.size(), 1U);
}

TEST(SafetyArea, RefusesTrajectoriesThatBeginOutsideAndLeavesThoseInsideAsTheyAre) {
  TrackedTrajectory inside = line({1, 1, 1}, {9, 4, 1}, 5), entering = line({-2, 1, 1}, {2, 1, 1}, 5),
                    outside = line({20, 1, 1}, {30, 1, 1}, 5);
  const SafetyVerdict kept = keep_inside(area(), &inside);
  EXPECT_TRUE(!kept.is_modified && kept.refusal.empty() && inside.points.size() == 5);
  EXPECT_EQ(keep_inside(area(), &entering).refusal, "the trajectory starts outside of the safety area!");
  EXPECT_EQ(keep_inside(area(), &outside).refusal, "the whole trajectory is outside of the safety area!");
}

TEST(SafetyArea, NeedsThreeCornersAndAHeight) {
  SafetyAreaConfig bad = area();
  bad.points_m = {0, 0, 1, 0, 1};
  bad.max_z_m = bad.min_z_m;
  EXPECT_EQ(bad.problems().size(), 2U);
  EXPECT_TRUE(area().problems().empty());
}

TEST(EstimatorSwitches, ComeAtRandomWithTheirMeanIntervalAndOnlyIfEnabled) {
  EstimatorSwitchesConfig config;
  EstimatorSwitches never(config, 1);
  config.is_enabled = true;
  config.interval_s = 10.0;
  EstimatorSwitches often(config, 1), same(config, 1);
  int count = 0;
  for (int i = 0; i < 200000; ++i) {
    const bool is_now = often.step(0.05);
    EXPECT_EQ(is_now, same.step(0.05));
    EXPECT_FALSE(never.step(0.05));
    count += is_now ? 1 : 0;
  }
  EXPECT_NEAR(count, 1000, 100);
}
