// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "uav_test_tools.hpp"
#include "voxnav_simulation/trajectory_generator.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test

TrackerLimits limits(ConstraintSet set) { return limits_of(UavConstraintsConfig{}, set); }

PathRequest request_through(std::vector<HeadedPoint> waypoints) {
  PathRequest request;
  request.waypoints = std::move(waypoints);
  request.limits = limits(ConstraintSet::kMedium);
  return request;
}

double distance(const HeadedPoint& a, const HeadedPoint& b) { return (a.position - b.position).norm(); }

TEST(TrajectoryGenerator, StraightLineReachesCruiseSpeedAndEndsAtRest) {
  const auto out = generate_trajectory({}, request_through({{{0, 0, 2}, 0}, {{40, 0, 2}, 0}}));
  ASSERT_TRUE(out.is_valid) << out.message;
  EXPECT_NEAR(out.dt_s, 0.2, 1e-12);
  EXPECT_LT(distance(out.samples.front(), {{0, 0, 2}, 0}), 1e-9);
  EXPECT_LT(distance(out.samples.back(), {{40, 0, 2}, 0}), 1e-6);
  double fastest = 0;
  for (std::size_t i = 1; i < out.samples.size(); ++i) {
    fastest = std::max(fastest, distance(out.samples[i], out.samples[i - 1]) / out.dt_s);
  }
  EXPECT_GT(fastest, 3.7);  // the limit is 4 m/s
  EXPECT_LT(distance(out.samples[out.samples.size() - 2], out.samples.back()), 0.05);
}

TEST(TrajectoryGenerator, ContinuesAStateInMotion) {
  PathRequest request = request_through({{{20, 10, 3}, 1}, {{30, 10, 3}, 1}});
  KinematicState start;
  start.position = Vec3(1, 2, 3);
  start.velocity = Vec3(2.5, 0.4, -0.2);
  start.acceleration = Vec3(-0.8, 0.9, 0.3);
  start.heading_rad = 0.3;
  start.heading_rate = 0.4;
  request.start = start;
  TrajectoryGeneratorConfig config;
  config.sampling_s = 0.02;
  const auto out = generate_trajectory(config, request);
  ASSERT_TRUE(out.is_valid) << out.message;
  const double t = out.dt_s;
  const Vec3 expected = start.position + start.velocity * t + 0.5 * t * t * start.acceleration;
  EXPECT_LT((out.samples[0].position - start.position).norm(), 1e-9);
  EXPECT_LT((out.samples[1].position - expected).norm(), 1e-4);  // the jerk adds 5e-5 at most
  EXPECT_NEAR(out.samples[1].heading_rad, 0.3 + 0.4 * t, 0.01);
  EXPECT_NEAR(out.samples.back().heading_rad, 1.0, 0.01);
}

TEST(TrajectoryGenerator, StopsAtWaypointsWhenAsked) {
  PathRequest request = request_through({{{0, 0, 2}, 0}, {{10, 0, 2}, 0}, {{10, 10, 2}, 0}});
  request.stop_at_waypoints = true;
  const auto out = generate_trajectory({}, request);
  ASSERT_TRUE(out.is_valid) << out.message;
  const std::size_t at = out.waypoint_samples[1];
  EXPECT_LT(distance(out.samples[at], request.waypoints[1]), 0.02);
  EXPECT_LT(distance(out.samples[at], out.samples[at + 1]) + distance(out.samples[at], out.samples[at - 1]), 0.06);
  EXPECT_LT(out.deviation_m, 1e-6);
}

TEST(TrajectoryGenerator, IsFasterTheMoreItMayDeviateAtCorners) {
  PathRequest request = request_through({{{0, 0, 2}, 0}, {{10, 0, 2}, 0}, {{20, 5, 2}, 0}, {{30, 5, 2}, 0}});
  request.max_deviation_m = 0.05;
  const auto narrow = generate_trajectory({}, request);
  request.max_deviation_m = 0.5;
  const auto wide = generate_trajectory({}, request);
  ASSERT_TRUE(narrow.is_valid && wide.is_valid);
  EXPECT_LT(wide.samples.size(), narrow.samples.size());
}

TEST(TrajectoryGenerator, LoopReturnsToTheFirstWaypoint) {
  PathRequest request = request_through({{{0, 0, 2}, 0}, {{10, 0, 2}, 0}, {{10, 10, 2}, 0}});
  request.is_loop = true;
  const auto out = generate_trajectory({}, request);
  ASSERT_TRUE(out.is_valid);
  EXPECT_LT(distance(out.samples.front(), out.samples.back()), 1e-6);
}

TEST(TrajectoryGenerator, HeadingOptions) {
  PathRequest request = request_through({{{0, 0, 2}, 0}, {{10, 0, 2}, 2}, {{20, 0, 2}, 1}});
  EXPECT_NEAR(generate_trajectory({}, request).samples.back().heading_rad, 1.0, 0.01);
  request.use_heading = false;
  for (const auto& sample : generate_trajectory({}, request).samples) EXPECT_EQ(sample.heading_rad, 0.0);
  request.use_heading = true;
  request.has_relaxed_heading = true;
  for (const auto& sample : generate_trajectory({}, request).samples) EXPECT_LT(sample.heading_rad, 1.05);
  request.has_heading_of_motion = true;
  request.waypoints[1].position = Vec3(0, 10, 2);
  request.waypoints[2].position = Vec3(0, 20, 2);
  EXPECT_NEAR(generate_trajectory({}, request).samples.back().heading_rad, M_PI / 2, 0.02);
}

TEST(TrajectoryGenerator, TurnsOnTheSpot) {
  const auto out = generate_trajectory({}, request_through({{{1, 1, 2}, 0}, {{1, 1, 2}, 2}}));
  ASSERT_TRUE(out.is_valid);
  EXPECT_NEAR(out.samples.back().heading_rad, 2.0, 0.01);
  for (const auto& sample : out.samples) EXPECT_LT(distance(sample, {{1, 1, 2}, 0}), 1e-9);
}

TEST(TrajectoryGenerator, RefusesBadRequestsWithAReason) {
  EXPECT_EQ(generate_trajectory({}, request_through({})).message, "the path is empty");
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(generate_trajectory({}, request_through({{{0, 0, 0}, 0}, {{1, nan, 0}, 0}})).message.find("finite"),
            std::string::npos);
  TrajectoryGeneratorConfig config;
  config.max_waypoints = 2;
  EXPECT_NE(generate_trajectory(config, request_through(std::vector<HeadedPoint>(3))).message.find("waypoints"),
            std::string::npos);
  config.max_duration_s = 10;
  const auto far = generate_trajectory(config, request_through({{{0, 0, 0}, 0}, {{1000, 0, 0}, 0}}));
  EXPECT_FALSE(far.is_valid);
  EXPECT_NE(far.message.find("longer than"), std::string::npos);
  PathRequest request = request_through({{{0, 0, 0}, 0}, {{1, 0, 0}, 0}});
  request.max_deviation_m = nan;
  EXPECT_TRUE(generate_trajectory({}, request).is_valid);  // NaN is not positive, so the default deviation is used
}

}  // namespace
