// SPDX-License-Identifier: BSD-3-Clause
// The generated trajectory keeps its limits, by finite differences, and passes every waypoint within the requested
// deviation, whatever the waypoints and the start.
#include <gtest/gtest.h>

#include "../unit/simulation/uav_test_tools.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test
using namespace uav_test;           // NOLINT: test

constexpr double kFine_s = 0.01;

std::vector<Vec3> positions(const GeneratedTrajectory& trajectory) {
  std::vector<Vec3> out;
  for (const auto& sample : trajectory.samples) out.push_back(sample.position);
  return out;
}

PathRequest random_request(int seed, std::mt19937* random) {
  PathRequest request;
  request.limits = limits_of(UavConstraintsConfig{}, static_cast<ConstraintSet>(seed % 3));
  const double steps_m[] = {0.4, 1, 4, 15};
  request.waypoints = random_path(random, 10, steps_m[seed % 4]);
  request.max_deviation_m = seed % 2 == 0 ? 0.05 : 0.3;
  return request;
}

GeneratedTrajectory generate(const PathRequest& request, double sampling_s) {
  TrajectoryGeneratorConfig config;
  config.sampling_s = sampling_s;
  return generate_trajectory(config, request);
}

TEST(TrajectoryLimits, HoldFromRestAndWaypointsAreReached) {
  for (int seed = 0; seed < 60; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const PathRequest request = random_request(seed, &random);
    const auto out = generate(request, kFine_s);
    ASSERT_TRUE(out.is_valid) << out.message;
    EXPECT_LE(usage(positions(out), kFine_s, request.limits).worst(), 0.96) << "seed " << seed;
    for (const Vec3& p : positions(out)) {
      ASSERT_LE(distance_to_path(p, request.waypoints), request.max_deviation_m * 1.001) << "seed " << seed;
    }
    for (std::size_t i = 0; i < request.waypoints.size(); ++i) {
      const Vec3 reached = out.samples[out.waypoint_samples[i]].position;
      EXPECT_LE((reached - request.waypoints[i].position).norm(), request.max_deviation_m * 1.1) << "seed " << seed;
    }
  }
}

TEST(TrajectoryLimits, HoldWhenContinuingAnyMotion) {
  for (int seed = 0; seed < 60; ++seed) {
    std::mt19937 random(static_cast<unsigned>(1000 + seed));
    PathRequest request = random_request(seed, &random);
    std::uniform_real_distribution<double> angle(-3.14, 3.14), unit(0, 1);
    const auto direction = [&](double length) -> Vec3 {
      const double a = angle(random);
      return Vec3(std::cos(a), std::sin(a), 0) * length;
    };
    KinematicState start;
    start.position = Vec3(0, 0, 5);
    start.velocity = direction(0.9 * unit(random) * request.limits.horizontal.speed) + Vec3(0, 0, 0.3);
    start.acceleration = direction(0.6 * unit(random) * request.limits.horizontal.acceleration) + Vec3(0, 0, 0.2);
    // A vehicle that keeps its limits does not accelerate much at full speed.
    if (start.velocity.dot(start.acceleration) > 0) start.acceleration *= 0.3;
    request.start = start;
    request.waypoints.erase(request.waypoints.begin());
    const auto out = generate(request, kFine_s);
    ASSERT_TRUE(out.is_valid) << out.message;
    const std::vector<Vec3> path = positions(out);
    EXPECT_LE(usage(path, kFine_s, request.limits).worst(), 1.0 + 1e-6) << "seed " << seed;
    const Vec3 velocity = (path[1] - path[0]) / kFine_s;
    EXPECT_LT((velocity - start.velocity - 0.5 * kFine_s * start.acceleration).norm(), 2e-3) << "seed " << seed;
    for (const HeadedPoint& waypoint : request.waypoints) {
      double nearest = 1e9;
      for (const Vec3& p : path) nearest = std::min(nearest, (p - waypoint.position).norm());
      EXPECT_LE(nearest, request.max_deviation_m * 1.1) << "seed " << seed;
    }
  }
}

TEST(TrajectoryLimits, CoarseSamplesAreThoseOfTheSameTrajectory) {
  for (int seed = 0; seed < 12; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    const PathRequest request = random_request(seed, &random);
    const auto fine = generate(request, kFine_s), coarse = generate(request, 0.2);
    for (std::size_t i = 0; i + 1 < coarse.samples.size(); ++i) {
      ASSERT_EQ(coarse.samples[i].position, fine.samples[20 * i].position);
    }
    EXPECT_EQ(coarse.samples.back().position, fine.samples.back().position);
  }
}

TEST(TrajectoryLimits, HeadingKeepsItsLimits) {
  for (int seed = 0; seed < 30; ++seed) {
    std::mt19937 random(static_cast<unsigned>(seed));
    PathRequest request = random_request(seed, &random);
    request.has_heading_of_motion = seed % 2 == 0;
    const auto out = generate(request, kFine_s);
    double previous_rate = 0;
    for (std::size_t i = 1; i < out.samples.size(); ++i) {
      const double change = voxnav::geometry::wrap_angle(out.samples[i].heading_rad - out.samples[i - 1].heading_rad);
      const double rate = change / kFine_s;
      EXPECT_LE(std::abs(rate), request.limits.heading.speed * 1.001) << "seed " << seed;
      EXPECT_LE(std::abs(rate - previous_rate) / kFine_s, request.limits.heading.acceleration * 1.001)
          << "seed " << seed;
      previous_rate = rate;
    }
  }
}

}  // namespace
