// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "../../../src/ros/odometry_origins.hpp"

using voxnav::geometry::from_position_yaw;
using voxnav::geometry::Pose;
using voxnav_ros::OdometryOrigins;

namespace {

const Pose kT_A_B = from_position_yaw({3.0, -2.0, 1.0}, 0.3), kT_B_C = from_position_yaw({-5.0, 4.0, 0.5}, -1.0);

}  // namespace

TEST(OdometryOrigins, ExpressPosesOfFormerOriginsInTheNewest) {
  OdometryOrigins origins;
  origins.begin("a");
  EXPECT_TRUE(origins.from("a")->isApprox(Pose::Identity()));
  EXPECT_FALSE(origins.from("b").has_value());
  origins.change("b", kT_A_B.inverse(), 4);
  EXPECT_EQ(origins.frame(), "b");
  EXPECT_TRUE(origins.from("a")->isApprox(kT_A_B.inverse()));
  origins.change("c", kT_B_C.inverse(), 7);
  EXPECT_TRUE(origins.from("a")->isApprox((kT_A_B * kT_B_C).inverse()));
  EXPECT_TRUE(origins.from("b")->isApprox(kT_B_C.inverse()));
  origins.change("a", kT_A_B * kT_B_C, 9);
  EXPECT_TRUE(origins.from("a")->isApprox(Pose::Identity()));
  EXPECT_TRUE(origins.from("b")->isApprox(kT_A_B));
}

TEST(OdometryOrigins, LeaveAPoseAsItIsWhereNothingChanges) {
  Pose pose = kT_A_B;
  pose.translation().z() = -0.0;
  EXPECT_TRUE(std::signbit(voxnav_ros::expressed(Pose::Identity(), pose).translation().z()));
  EXPECT_TRUE(voxnav_ros::expressed(kT_B_C, pose).isApprox(kT_B_C * pose));
}

TEST(OdometryOrigins, KnowTheOriginInWhichEachSubmapCame) {
  OdometryOrigins origins;
  origins.begin("a");
  EXPECT_TRUE(origins.from_that_of(3).isApprox(Pose::Identity()));
  origins.change("b", kT_A_B.inverse(), 4);
  origins.change("c", kT_B_C.inverse(), 7);
  EXPECT_TRUE(origins.from_that_of(3).isApprox((kT_A_B * kT_B_C).inverse()));
  EXPECT_TRUE(origins.from_that_of(4).isApprox(kT_B_C.inverse()));
  EXPECT_TRUE(origins.from_that_of(6).isApprox(kT_B_C.inverse()));
  EXPECT_TRUE(origins.from_that_of(7).isApprox(Pose::Identity()));
  // With a submap between the two changes that came late, both changes hold for it.
  origins.change("a", kT_A_B * kT_B_C, 7);
  EXPECT_TRUE(origins.from_that_of(3).isApprox(Pose::Identity()));
}

TEST(OdometryOrigins, ForgetTheFormerOnesWhenTheyBeginAnew) {
  OdometryOrigins origins;
  origins.begin("a");
  origins.change("b", kT_A_B.inverse(), 4);
  origins.begin("c");
  EXPECT_FALSE(origins.from("a").has_value());
  EXPECT_TRUE(origins.from_that_of(2).isApprox(Pose::Identity()));
}
