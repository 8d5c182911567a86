// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "voxnav/geometry/aabb.hpp"
#include "voxnav/geometry/pose.hpp"
#include "voxnav/geometry/voxel.hpp"

using namespace voxnav::geometry;  // NOLINT: test

TEST(Pose, YawSurvivesTilt) {
  // Yaw is the heading of the x axis, whatever roll and pitch are.
  for (int i = -10; i <= 10; ++i) {
    const double yaw = 0.3 * i;
    Pose tilted = Pose::Identity();
    tilted.linear() = (Eigen::AngleAxisd(yaw, Vec3::UnitZ()) * Eigen::AngleAxisd(0.4, Vec3::UnitY()) *
                       Eigen::AngleAxisd(-0.3, Vec3::UnitX()))
                          .toRotationMatrix();
    EXPECT_NEAR(yaw_of(tilted), yaw, 1e-12);
    EXPECT_NEAR(gravity_aligned(tilted).linear()(2, 2), 1.0, 1e-12);
  }
}

TEST(Pose, WrapAngleStaysInRangeAndKeepsDirection) {
  for (int i = -135; i <= 135; ++i) {
    const double angle = 0.37 * i;
    const double wrapped = wrap_angle(angle);
    EXPECT_GE(wrapped, -M_PI);
    EXPECT_LT(wrapped, M_PI);
    EXPECT_NEAR(std::cos(wrapped), std::cos(angle), 1e-9);
    EXPECT_NEAR(std::sin(wrapped), std::sin(angle), 1e-9);
  }
}

TEST(Pose, InvalidMatricesAreDetected) {
  Pose pose = Pose::Identity();
  EXPECT_TRUE(is_valid(pose));
  pose.translation().x() = std::nan("");
  EXPECT_FALSE(is_valid(pose));
  pose = Pose::Identity();
  pose.linear() *= 1.1;
  EXPECT_FALSE(is_valid(pose));
}

TEST(Voxel, IndexAndBlockRoundTripIncludingNegatives) {
  std::mt19937 rng(7);
  std::uniform_int_distribution<int> coordinate(-100000, 100000);
  for (int i = 0; i < 10000; ++i) {
    const Index3 voxel{coordinate(rng), coordinate(rng), coordinate(rng)};
    EXPECT_EQ(index_of(center_of(voxel, 0.4), 0.4), voxel);
    EXPECT_EQ(voxel_at(block_of(voxel), offset_in_block(voxel)), voxel);
  }
}

TEST(Aabb, TransformedBoxHoldsTransformedPoints) {
  Aabb box{{-1, -2, -3}, {1, 2, 3}};
  const Pose T = from_position_yaw({5, 6, 7}, 0.7);
  const Aabb moved = box.transformed(T).padded(1e-9);
  for (int c = 0; c < 8; ++c)
    EXPECT_TRUE(moved.contains(T * Vec3((c & 1) ? 1 : -1, (c & 2) ? 2 : -2, (c & 4) ? 3 : -3)));
  EXPECT_TRUE(Aabb().transformed(T).empty());
}
