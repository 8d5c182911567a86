// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "uav_test_tools.hpp"
#include "voxnav_simulation/uav.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test

ImuConfig perfect_imu() { return {0, 0, 0, 0, 0, 0}; }

Uav make_uav(unsigned seed = 1, const GnssDriftConfig& drift = {}, const ImuConfig& imu = {}) {
  UavSetup setup;
  setup.drift = drift;
  setup.imu = imu;
  return Uav(setup, seed);
}

void fly(Uav* uav, double duration_s) {
  for (int i = 0; i < static_cast<int>(std::lround(duration_s / kStep_s)); ++i) uav->step();
}

void take_off(Uav* uav) {
  ASSERT_TRUE(uav->take_off().success);
  for (int i = 0; i < 4000 && uav->phase() != FlightPhase::kFlying; ++i) uav->step();
  ASSERT_EQ(uav->phase(), FlightPhase::kFlying);
}

TEST(Uav, TakesOffFliesAndLands) {
  Uav uav = make_uav();
  EXPECT_NEAR(*uav.height_m(), 0.25, 1e-9);
  take_off(&uav);
  EXPECT_NEAR(*uav.height_m(), 2.0, 0.1);
  ASSERT_TRUE(uav.go_to({{10, 5, 4}, 1}).success);
  fly(&uav, 15);
  EXPECT_LT((uav.estimate().pose.translation() - Vec3(10, 5, 4)).norm(), 0.02);
  EXPECT_NEAR(voxnav::geometry::yaw_of(uav.estimate().pose), 1, 0.01);
  ASSERT_TRUE(uav.land().success);
  fly(&uav, 15);
  EXPECT_EQ(uav.phase(), FlightPhase::kIdle);
  EXPECT_NEAR(*uav.height_m(), 0.25, 0.03);
  take_off(&uav);
}

TEST(Uav, RefusesWhatItCannotDo) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Uav uav = make_uav();
  TrackedTrajectory trajectory;
  trajectory.points = {{{0, 0, 2}, 0}, {{1, 0, 2}, 0}};
  EXPECT_EQ(uav.set_trajectory(trajectory).message, "not flying: take off first");
  EXPECT_FALSE(uav.hover().success);
  EXPECT_FALSE(uav.land().success);
  ASSERT_TRUE(uav.take_off().success);
  EXPECT_FALSE(uav.take_off().success);
  EXPECT_FALSE(uav.go_to({{0, 0, 2}, 0}).success);
  fly(&uav, 20);
  EXPECT_FALSE(uav.go_to({{0, nan, 2}, 0}).success);
  EXPECT_TRUE(uav.set_trajectory(trajectory).success);
  trajectory.points[1].heading_rad = nan;
  EXPECT_NE(uav.set_trajectory(trajectory).message.find("not finite"), std::string::npos);
  trajectory.points[1] = {{3, 0, 2}, 0};
  trajectory.is_loop = true;
  EXPECT_NE(uav.set_trajectory(trajectory).message.find("loop"), std::string::npos);
  trajectory.is_loop = false;
  trajectory.skip_s = 1;
  EXPECT_NE(uav.set_trajectory(trajectory).message.find("over"), std::string::npos);
  trajectory.skip_s = 0;
  trajectory.dt_s = 0.005;
  EXPECT_NE(uav.set_trajectory(trajectory).message.find("dt"), std::string::npos);
  trajectory.points.clear();
  EXPECT_NE(uav.set_trajectory(trajectory).message.find("empty"), std::string::npos);
}

TEST(Uav, DriftIsBoundedContinuousAndReachesFar) {
  GnssDriftConfig config;
  config.walk_m = 0.3;
  Uav uav = make_uav(3, config);
  take_off(&uav);
  Vec3 last = uav.drift();
  double largest = 0;
  for (int i = 0; i < 120000; ++i) {
    uav.step();
    EXPECT_LT((uav.drift() - last).norm(), 0.01);
    EXPECT_LT((uav.estimate().pose.translation() - uav.truth().pose.translation() - uav.drift()).norm(), 1e-9);
    last = uav.drift();
    largest = std::max(largest, last.norm());
  }
  EXPECT_LE(largest, 2.0);
  EXPECT_GT(largest, 1.0);
}

TEST(Uav, HoldsTheEstimateWhileTheTruthDrifts) {
  Uav uav = make_uav(5);
  take_off(&uav);
  const Vec3 held = uav.estimate().pose.translation();
  fly(&uav, 60);
  EXPECT_LT((uav.estimate().pose.translation() - held).norm(), 0.05);
  EXPECT_GT((uav.truth().pose.translation() - held).norm(), 0.1);
}

TEST(Uav, ImuIntegratesToTheTruth) {
  Uav uav = make_uav(2, {}, perfect_imu());
  take_off(&uav);
  TrackedTrajectory trajectory;
  for (int i = 0; i < 100; ++i) {
    const double t = 0.2 * i;
    trajectory.points.push_back({{4 * std::sin(0.3 * t), 3 * t * t / (5 + t), 2 + 0.5 * std::sin(t)}, 0.2 * t});
  }
  ASSERT_TRUE(uav.set_trajectory(trajectory).success);
  Eigen::Matrix3d R = uav.truth().pose.linear();
  Vec3 v = uav.truth().velocity, p = uav.truth().pose.translation();
  for (int i = 0; i < 4000; ++i) {
    uav.step();
    const Eigen::AngleAxisd half(0.5 * kStep_s * uav.imu().gyro.norm(), uav.imu().gyro.normalized());
    const Vec3 a = R * half * uav.imu().accel - Vec3(0, 0, kGravity);
    R = R * half * half;
    p += v * kStep_s + 0.5 * kStep_s * kStep_s * a;
    v += a * kStep_s;
  }
  EXPECT_LT((p - uav.truth().pose.translation()).norm(), 0.05);
  EXPECT_LT((v - uav.truth().velocity).norm(), 0.01);
  EXPECT_LT(Eigen::AngleAxisd(R.transpose() * uav.truth().pose.linear()).angle(), 1e-3);
}

TEST(Uav, ImuHasBiasAndNoise) {
  ImuConfig config;
  Uav uav = make_uav(4, {}, config);
  Vec3 mean = Vec3::Zero(), squares = Vec3::Zero();
  constexpr int kCount = 20000;
  for (int i = 0; i < kCount; ++i) {
    uav.step();
    mean += uav.imu().gyro / kCount;
    squares += uav.imu().gyro.cwiseAbs2() / kCount;
  }
  const double sigma = config.gyro_noise / std::sqrt(kStep_s);
  for (int i = 0; i < 3; ++i) EXPECT_NEAR(std::sqrt(squares[i] - mean[i] * mean[i]) / sigma, 1, 0.1);
  EXPECT_GT(mean.norm(), 0.001);
  EXPECT_LT(mean.norm(), 0.02);
}

TEST(Uav, TiltsTowardsItsAcceleration) {
  const Eigen::Matrix3d R = attitude_of(Vec3(2, 0, 0), 0.7);
  EXPECT_LT((R.transpose() * R - Eigen::Matrix3d::Identity()).norm(), 1e-12);
  EXPECT_NEAR(std::atan2(R(1, 0), R(0, 0)), 0.7, 1e-12);
  EXPECT_LT((R * Vec3(0, 0, std::hypot(2, kGravity)) - Vec3(2, 0, kGravity)).norm(), 1e-9);
}

TEST(Uav, RangefinderSeesTheGround) {
  Uav uav = make_uav();
  take_off(&uav);
  fly(&uav, 5);
  EXPECT_NEAR(*uav.rangefinder(), *uav.height_m(), 0.1);
}

TEST(Uav, SameSeedSameFlight) {
  Uav a = make_uav(7), b = make_uav(7), c = make_uav(8);
  for (Uav* uav : {&a, &b, &c}) take_off(uav), fly(uav, 20);
  EXPECT_EQ(a.truth().pose.matrix(), b.truth().pose.matrix());
  EXPECT_EQ(a.imu().accel, b.imu().accel);
  EXPECT_NE(a.truth().pose.matrix(), c.truth().pose.matrix());
}

}  // namespace
