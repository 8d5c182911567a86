// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "voxnav/planning/trajectory.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using planning::Trajectory;

namespace {

/// Returns a trajectory along x at 2 m/s for 10 s.
Trajectory cruise() {
  std::vector<Vec3> points;
  for (int i = 0; i <= 50; ++i) points.emplace_back(0.4 * i, 0.0, 0.0);
  return {points, 0.2};
}

}  // namespace

TEST(Trajectory, ReadsByTimeAndByArc) {
  const Trajectory t = cruise();
  EXPECT_DOUBLE_EQ(t.duration_s(), 10.0);
  EXPECT_NEAR(t.length_m(), 20.0, 1e-9);
  EXPECT_NEAR(t.position_at(3.05).x(), 6.1, 1e-9);
  EXPECT_NEAR(t.position_at(99.0).x(), 20.0, 1e-9);
  EXPECT_NEAR(t.position_at(-1.0).x(), 0.0, 1e-9);
  EXPECT_NEAR(t.speed_at(5.0), 2.0, 1e-9);
  EXPECT_DOUBLE_EQ(t.speed_at(10.0), 0.0);
  EXPECT_NEAR(t.project({6.3, 0.5, 0.0}, 2.0, 4.0), 6.3, 1e-9);
  EXPECT_NEAR(t.points_from_arc(19.9).front().x(), 19.9, 1e-9);
}

TEST(Trajectory, StopsAtAnArcWithBoundedDeceleration) {
  const auto stopped = cruise().stopped_at(4.0, 10.0, 1.0);
  ASSERT_TRUE(stopped.has_value());
  EXPECT_NEAR(stopped->points().front().x(), 4.0, 1e-9);
  EXPECT_NEAR(stopped->points().back().x(), 10.0, 1e-9);
  const auto& p = stopped->points();
  double before = 2.0;
  for (std::size_t i = 1; i < p.size(); ++i) {
    const double speed = (p[i] - p[i - 1]).norm() / 0.2;
    EXPECT_LE(speed, 2.0 + 1e-9);
    EXPECT_GE(speed, before - (1.0 + 0.3) * 0.2) << "at " << i;
    before = speed;
  }
}

TEST(Trajectory, TellsWhenItBeginsToBrake) {
  EXPECT_NEAR(cruise().braking_begins_s(), 9.8, 1e-9) << "a cruise stops at once at its end";
  // At 2 m/s, 10 m are needed to stop at 0.2 m/s^2: braking begins where they are left, after 5 s.
  EXPECT_NEAR(cruise().stopped_at(0.0, 20.0, 0.2)->braking_begins_s(), 5.0, 0.41);
  EXPECT_NEAR(cruise().stopped_at(0.0, 10.0, 0.2)->braking_begins_s(), 0.0, 0.41);
  EXPECT_EQ(Trajectory({Vec3(1, 2, 3)}, 0.2).braking_begins_s(), 0.0);
}

TEST(Trajectory, RefusesToStopWhereItCannot) {
  EXPECT_FALSE(cruise().stopped_at(4.0, 5.5, 1.0).has_value());  // stopping needs 2 m
  EXPECT_FALSE(cruise().stopped_at(4.0, 3.0, 1.0).has_value());
  EXPECT_TRUE(cruise().stopped_at(4.0, 6.1, 1.0).has_value());
}

TEST(Trajectory, UnusablePointsAreRefused) {
  EXPECT_THROW(Trajectory({}, 0.2), std::invalid_argument);
  EXPECT_THROW(Trajectory({Vec3(0, 0, std::nan(""))}, 0.2), std::invalid_argument);
  EXPECT_THROW(Trajectory({Vec3(0, 0, 0)}, 0.0), std::invalid_argument);
}

TEST(Trajectory, LevelFlightBrakesByTheHorizontalLimit) {
  const planning::DynamicsLimits limits{4.0, 2.0, 2.0, 1.0, 2.0, 0.8};
  const Vec3 still = Vec3::Zero();
  EXPECT_DOUBLE_EQ(braking_deceleration(cruise(), 4.0, 10.0, still, limits), 2.0);
  EXPECT_DOUBLE_EQ(braking_deceleration(cruise(), 4.0, 10.0, {2.0, 0.0, 0.02}, limits), 2.0);
  EXPECT_DOUBLE_EQ(braking_deceleration(cruise(), 4.0, 10.0, {0.0, 0.0, 1.0}, limits), 0.8) << "the vehicle climbs";
}

TEST(Trajectory, SteepFlightBrakesByTheTighterVerticalLimitWhicheverTheDirection) {
  const planning::DynamicsLimits limits{4.0, 2.0, 2.0, 1.0, 2.0, 0.8};
  const Vec3 still = Vec3::Zero();
  for (const double z : {1.0, -1.0}) {
    const Trajectory steep({Vec3(0, 0, 0), Vec3(0, 0, z), Vec3(0, 0, 2 * z)}, 0.5);
    EXPECT_DOUBLE_EQ(braking_deceleration(steep, 0.0, 2.0, still, limits), 0.8);
    const Trajectory slope({Vec3(0, 0, 0), Vec3(1, 0, z), Vec3(2, 0, 2 * z)}, 0.5);
    EXPECT_NEAR(braking_deceleration(slope, 0.0, 2.0, still, limits), 0.8 * std::sqrt(2.0), 1e-12);
  }
  const Trajectory late({Vec3(0, 0, 0), Vec3(2, 0, 0), Vec3(2, 0, 2)}, 0.5);
  EXPECT_DOUBLE_EQ(braking_deceleration(late, 0.0, 2.0, still, limits), 2.0) << "stops before the climb";
  EXPECT_DOUBLE_EQ(braking_deceleration(late, 0.0, 2.5, still, limits), 0.8);
}
