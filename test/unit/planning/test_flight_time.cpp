// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "planning/flight_time.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;

namespace {
const planning::DynamicsLimits kLimits{4.0, 2.0, 2.0, 1.0, 1.0, 1.0};
}

TEST(FlightTime, LimitsAlongADirectionAreTheTighterShare) {
  EXPECT_DOUBLE_EQ(planning::limits_along({1, 0, 0}, kLimits).speed_mps, 4.0);
  EXPECT_DOUBLE_EQ(planning::limits_along({0, 0, 3}, kLimits).speed_mps, 2.0);
  EXPECT_DOUBLE_EQ(planning::limits_along({0, 0, -1}, kLimits).speed_mps, 1.0);
  EXPECT_NEAR(planning::limits_along({1, 0, 1}, kLimits).speed_mps, 2.0 * std::sqrt(2.0), 1e-12);
}

TEST(FlightTime, RestToRestHasTheClosedForm) {
  EXPECT_NEAR(planning::rest_to_rest_time(20.0, {4.0, 2.0}), 20.0 / 4.0 + 4.0 / 2.0, 1e-12);
  EXPECT_NEAR(planning::rest_to_rest_time(2.0, {4.0, 2.0}), 2.0 * std::sqrt(2.0 / 2.0), 1e-12);
}

TEST(FlightTime, SplittingAStraightLineChangesNothing) {
  const auto whole = planning::passing_times({{0, 0, 0}, {20, 0, 0}}, kLimits, 0.2);
  const auto split = planning::passing_times({{0, 0, 0}, {3, 0, 0}, {5, 0, 0}, {19.5, 0, 0}, {20, 0, 0}}, kLimits, 0.2);
  EXPECT_NEAR(split.back(), whole.back(), 1e-9);
}

TEST(FlightTime, SharpCornersCostTimeAndReversalsNeedAStop) {
  const double straight = planning::passing_times({{0, 0, 0}, {10, 0, 0}, {20, 0, 0}}, kLimits, 0.2).back();
  const double corner = planning::passing_times({{0, 0, 0}, {10, 0, 0}, {10, 10, 0}}, kLimits, 0.2).back();
  const double reversal = planning::passing_times({{0, 0, 0}, {10, 0, 0}, {0, 0, 0}}, kLimits, 0.2).back();
  EXPECT_GT(corner, straight);
  EXPECT_NEAR(reversal, 2.0 * planning::rest_to_rest_time(10.0, {4.0, 2.0}), 1e-6);
}

TEST(FlightTime, CutEndsInsideAPieceExactlyAtTheTime) {
  const std::vector<Vec3> line = {{0, 0, 0}, {30, 0, 0}, {30, 60, 0}};
  const auto cut = planning::cut_at_time(line, kLimits, 0.2, 15.0);
  ASSERT_EQ(cut.size(), 3u);
  EXPECT_GT(cut.back().y(), 0.0);
  EXPECT_LT(cut.back().y(), 60.0);
  EXPECT_NEAR(planning::passing_times(cut, kLimits, 0.2).back(), 15.0, 1e-6);
  EXPECT_EQ(planning::cut_at_time(line, kLimits, 0.2, 100.0).size(), line.size());
}

TEST(FlightTime, CutAtALengthKeepsThePathBeforeIt) {
  const std::vector<Vec3> line = {{0, 0, 0}, {3, 0, 0}, {3, 4, 0}};
  const auto cut = planning::cut_at_length(line, 5.0);
  ASSERT_EQ(cut.size(), 3u);
  EXPECT_NEAR((cut.back() - Vec3(3, 2, 0)).norm(), 0.0, 1e-12);
  EXPECT_EQ(planning::cut_at_length(line, 50.0).size(), 3u);
  EXPECT_EQ(planning::cut_at_length(line, 0.0).size(), 2u);
}
