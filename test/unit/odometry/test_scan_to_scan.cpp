// SPDX-License-Identifier: BSD-3-Clause
/// The odometry of the thesis, scan to scan by PCL, beside the one against a map.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <random>
#include <utility>

#include "room_world.hpp"
#include "voxnav/odometry/lidar_odometry.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Pose;
using geometry::Vec3;
using odometry::LidarOdometry;
using odometry::LidarOdometryConfig;
using odometry::OdometryResult;
using odometry::OdometryState;
using odometry::RegistrationMethod;

/// A curve that begins at rest.
Pose flight(double time) {
  const double t = time > 0 ? time * time / (1 + time) : 0.0;
  return geometry::from_position_yaw(Vec3(2.0 * (1 - std::cos(0.8 * t)), 1.2 * (1 - std::cos(0.6 * t)), 0.1 * t),
                                     0.8 * (1 - std::cos(0.5 * t)));
}

base::StampNs stamp_of(double t) { return base::from_seconds(1000.0 + t); }

struct Followed {
  double worst_m = 0.0;
  int num_tracking = 0;
  OdometryResult last;
};

Followed follow(RegistrationMethod method, int num_scans) {
  const test::RoomWorld world = test::RoomWorld::hall();
  LidarOdometryConfig config;
  config.registration = method;
  config.use_imu = false;
  LidarOdometry odometry(config);
  Followed out;
  for (int i = 0; i < num_scans; ++i) {
    const double t = 0.1 * i;
    const auto sweep = test::sweep_of(world, flight, t, 0.01, static_cast<std::uint32_t>(i));
    out.last = odometry.add_cloud(stamp_of(t), sweep.points_L, sweep.times_s);
    out.worst_m = std::max(out.worst_m, (out.last.T_O_B.translation() - flight(t).translation()).norm());
    out.num_tracking += out.last.quality.state == OdometryState::kTracking;
  }
  return out;
}

}  // namespace

TEST(ScanToScan, FollowsAFlightAndDriftsMoreThanTheMap) {
  // Point to point, the rings of a sparse LiDAR hold on to those of the scan before; planes do not.
  const std::pair<RegistrationMethod, double> most_m[] = {{RegistrationMethod::kIcp, 4.0},
                                                          {RegistrationMethod::kGicp, 0.5}};
  const Followed map = follow(RegistrationMethod::kMap, 60);
  RecordProperty("map", std::to_string(map.worst_m));
  for (const auto& [method, bound_m] : most_m) {
    const Followed found = follow(method, 60);
    RecordProperty(base::word_of(method), std::to_string(found.worst_m));
    EXPECT_GT(found.num_tracking, 50) << base::word_of(method);
    EXPECT_LT(found.worst_m, bound_m) << base::word_of(method);
    EXPECT_GT(found.worst_m, map.worst_m) << base::word_of(method);
    EXPECT_GT(found.last.quality.iterations, 0);
  }
}

TEST(ScanToScan, CovarianceGrowsWithEveryScan) {
  double before = 0.0;
  for (const int num_scans : {10, 20, 40}) {
    const double variance = follow(RegistrationMethod::kIcp, num_scans).last.covariance.diagonal().head<3>().sum();
    EXPECT_GT(variance, before);
    before = variance;
  }
}

TEST(ScanToScan, WhatDoesNotFitTheScanBeforeIsNotTaken) {
  const test::RoomWorld world = test::RoomWorld::hall();
  LidarOdometryConfig config;
  config.registration = RegistrationMethod::kIcp;
  config.use_imu = false;
  LidarOdometry odometry(config);
  const auto still = [](double) { return Pose::Identity(); };
  for (int i = 0; i < 5; ++i) {
    odometry.add_cloud(stamp_of(0.1 * i), test::sweep_of(world, still, 0.0, 0.01, 1).points_L);
  }
  std::mt19937 random(3);
  std::uniform_real_distribution<float> in(-40, 40);
  std::vector<geometry::Vec3f> garbage(20000);
  for (auto& p : garbage) p = {in(random), in(random), in(random)};
  const OdometryResult lost = odometry.add_cloud(stamp_of(0.5), garbage);
  EXPECT_EQ(lost.quality.state, OdometryState::kCoasting);
  EXPECT_LT(lost.T_O_B.translation().norm(), 0.1);
}

TEST(ScanToScan, ResetForgetsTheScanBefore) {
  LidarOdometryConfig config;
  config.registration = RegistrationMethod::kGicp;
  config.use_imu = false;
  LidarOdometry odometry(config);
  const auto sweep = test::sweep_of(test::RoomWorld::hall(), flight, 0.0, 0.01, 1);
  odometry.add_cloud(stamp_of(0.0), sweep.points_L, sweep.times_s);
  odometry.reset();
  const OdometryResult first = odometry.add_cloud(stamp_of(5.0), sweep.points_L, sweep.times_s);
  EXPECT_EQ(first.quality.reason_kind, odometry::OdometryReason::kFirstScan);
}
