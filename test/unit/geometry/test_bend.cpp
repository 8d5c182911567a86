// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/geometry/pose.hpp"

using namespace voxnav::geometry;  // NOLINT: test

TEST(Bend, IsRigidByDefault) {
  EXPECT_TRUE(Bend{}.is_rigid());
  for (int i = 0; i <= 10; ++i) EXPECT_EQ(Bend{}.at(0.1 * i).matrix(), Pose::Identity().matrix());
}

TEST(Bend, GrowsEvenlyFromTheMiddleToEitherEnd) {
  const Bend bend{from_position_yaw({-0.4, 0.2, 0.1}, 0.04), from_position_yaw({0.6, -0.2, 0.0}, -0.02)};
  EXPECT_FALSE(bend.is_rigid());
  EXPECT_TRUE(bend.at(0.0).isApprox(bend.T_S_begin, 1e-12));
  EXPECT_TRUE(bend.at(0.5).isApprox(Pose::Identity(), 1e-12));
  EXPECT_TRUE(bend.at(1.0).isApprox(bend.T_S_end, 1e-12));
  EXPECT_TRUE(bend.at(0.25).translation().isApprox(Vec3(-0.2, 0.1, 0.05), 1e-12));
  EXPECT_NEAR(yaw_of(bend.at(0.25)), 0.02, 1e-12);
  EXPECT_TRUE(bend.at(0.875).translation().isApprox(Vec3(0.45, -0.15, 0.0), 1e-12));
}
