// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "odometry/gravity.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using odometry::Gravity;
using odometry::MeanForce;

TEST(Gravity, TheDirectionDecidesInAnyUnit) {
  const Vec3 up = Vec3(0.3, -0.2, -0.9).normalized();
  for (const double norm : {9.81, 8.0, 11.8, 1.0, 1.1, 1000.0, 981.0, 9810.0}) {
    const auto found = Gravity::up_at_rest({norm * up, norm});
    ASSERT_TRUE(found) << norm;
    EXPECT_LT((*found - up).norm(), 1e-12);
    EXPECT_LT((odometry::levelling(*found) * up - Vec3::UnitZ()).norm(), 1e-9);
  }
}

TEST(Gravity, NothingIsUpWhereForcesAreNoneOrOneAgainstAnother) {
  EXPECT_FALSE(Gravity::up_at_rest({Vec3::Zero(), 0.0}));
  EXPECT_FALSE(Gravity::up_at_rest({Vec3(0, 0, 0.05), 0.06}));  // an IMU that takes gravity out
  EXPECT_FALSE(Gravity::up_at_rest({Vec3(0, 0, 3.0), 3.0}));
  EXPECT_FALSE(Gravity::up_at_rest({Vec3(0, 0, 9.81), 14.0}));  // shaken more than it is held
  EXPECT_FALSE(Gravity().up_O(0.0));
}

TEST(Gravity, MotionIsTakenOutOfTheForce) {
  for (const double unit : {1.0, 1.0 / 9.81}) {
    Gravity gravity;
    const Vec3 up = Vec3(0.2, 0.1, 1.0).normalized();
    for (int i = 0; i < 30; ++i) {
      const Vec3 acceleration(1.5, std::sin(0.3 * i), 0.5);
      gravity.add(unit * (9.81 * up + acceleration), 0.1 * acceleration, 0.1);
    }
    EXPECT_FALSE(gravity.up_O(3.5));
    ASSERT_TRUE(gravity.up_O(2.0));
    EXPECT_LT((*gravity.up_O(2.0) - up).norm(), 1e-9);
    gravity.clear();
    EXPECT_FALSE(gravity.up_O(0.1));
  }
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
