// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "odometry/gravity.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using odometry::Gravity;

TEST(Gravity, TheDirectionDecidesInAnyUnit) {
  const Vec3 up = Vec3(0.3, -0.2, -0.9).normalized();
  for (const double norm : {9.81, 8.0, 11.8, 1.0, 1.1, 1000.0, 981.0, 9810.0}) {
    const auto found = Gravity::up_at_rest({norm * up, norm});
    ASSERT_TRUE(found) << norm;
    EXPECT_LT((*found - up).norm(), 1e-12);
    EXPECT_LT((odometry::levelling(*found) * up - Vec3::UnitZ()).norm(), 1e-9);
  }
}

TEST(Gravity, ReturnsNothingIfForcesAreMissingOrContradictEachOther) {
  EXPECT_FALSE(Gravity::up_at_rest({Vec3::Zero(), 0.0}));
  EXPECT_FALSE(Gravity::up_at_rest({Vec3(0, 0, 0.05), 0.06}));  // the IMU subtracts gravity
  EXPECT_FALSE(Gravity::up_at_rest({Vec3(0, 0, 3.0), 3.0}));
  EXPECT_FALSE(Gravity::up_at_rest({Vec3(0, 0, 9.81), 14.0}));  // the vehicle is shaken more than it is held
  EXPECT_FALSE(Gravity().up_O(0.0));
}

/// Feeds the forces and positions of a flight of num_spans times 0.1 s.
/// @param unit     1 m/s^2 in the unit of the forces
/// @param error_m  standard deviation of the positions
Gravity flown(const Vec3& up, int num_spans, double unit, double error_m) {
  std::mt19937 random(3);
  std::normal_distribution<double> noise(0.0, error_m > 0.0 ? error_m : 1.0);
  const auto erroneous = [&](const Vec3& at) {
    return error_m > 0.0 ? Vec3(at + Vec3(noise(random), noise(random), noise(random))) : at;
  };
  Gravity gravity;
  Vec3 at(3, 2, 1), velocity(2.0, -1.0, 0.3);
  Vec3 from = erroneous(at);
  for (int i = 0; i < num_spans; ++i) {
    const Vec3 acceleration(1.5, std::sin(0.3 * i), 0.5);
    at += 0.1 * velocity + 0.005 * acceleration;
    velocity += 0.1 * acceleration;
    const Vec3 to = erroneous(at);
    gravity.add(unit * (9.81 * up + acceleration), from, to, 0.1);
    from = to;
  }
  return gravity;
}

TEST(Gravity, MotionIsTakenOutOfTheForce) {
  const Vec3 up = Vec3(0.2, 0.1, 1.0).normalized();
  for (const double unit : {1.0, 1.0 / 9.81}) {
    Gravity gravity = flown(up, 30, unit, 0.0);
    EXPECT_FALSE(gravity.up_O(3.5));
    ASSERT_TRUE(gravity.up_O(2.0));
    EXPECT_LT((*gravity.up_O(2.0) - up).norm(), 1e-9);
    gravity.clear();
    EXPECT_FALSE(gravity.up_O(0.1));
    EXPECT_FALSE(flown(up, 2, unit, 0.0).up_O(0.1)) << "three positions do not overdetermine a parabola";
  }
}

TEST(Gravity, ErrorsOfPositionsTiltItByLittle) {
  const Vec3 up = Vec3(0.2, 0.1, 1.0).normalized();
  EXPECT_LT((*flown(up, 20, 1.0, 0.01).up_O(1.9) - up).norm(), 0.006);  // this is a third of a degree
  EXPECT_LT((*flown(up, 20000, 1.0, 0.01).up_O(1.9) - up).norm(), 1e-6) << "half an hour";
}

TEST(Gravity, LevellingKeepsTheHeading) {
  for (const Vec3& up : {Vec3(0, 0, 1), Vec3(0.5, 0, 1), Vec3(0.1, -0.7, 0.3), Vec3(0, 0, -1)}) {
    const Eigen::Matrix3d R = odometry::levelling(up.normalized());
    EXPECT_LT((R * up.normalized() - Vec3::UnitZ()).norm(), 1e-9);
    EXPECT_NEAR(R.determinant(), 1.0, 1e-9);
    EXPECT_NEAR(geometry::yaw_of(geometry::Pose(Eigen::Quaterniond(R))), 0.0, 1e-9);
  }
}

}  // namespace
