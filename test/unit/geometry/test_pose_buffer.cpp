// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "geometry/pose_buffer.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::from_position_yaw;
using geometry::Pose;
using geometry::PoseBuffer;
using geometry::Vec3;

TEST(PoseBuffer, InterpolatesAndNeverExtrapolates) {
  PoseBuffer buffer;
  EXPECT_FALSE(buffer.at(0));
  EXPECT_TRUE(buffer.add(1'000'000'000, from_position_yaw(Vec3::Zero(), 3.0)));
  EXPECT_TRUE(buffer.add(2'000'000'000, from_position_yaw(Vec3(2, 0, 0), -3.0)));
  const auto middle = buffer.at(1'500'000'000);
  ASSERT_TRUE(middle);
  EXPECT_LT((middle->translation() - Vec3(1, 0, 0)).norm(), 1e-12);
  EXPECT_NEAR(std::abs(geometry::yaw_of(*middle)), M_PI, 1e-9);  // the shorter of the two rotations is interpolated
  EXPECT_TRUE(buffer.at(1'000'000'000)->matrix() == from_position_yaw(Vec3::Zero(), 3.0).matrix());
  EXPECT_TRUE(buffer.at(2'000'000'000)->matrix() == from_position_yaw(Vec3(2, 0, 0), -3.0).matrix());
  EXPECT_FALSE(buffer.at(999'999'999));
  EXPECT_FALSE(buffer.at(2'000'000'001));
  EXPECT_TRUE(buffer.is_before_all(999'999'999));
  EXPECT_FALSE(buffer.is_before_all(2'000'000'001));
}

TEST(PoseBuffer, RefusesLateStrayAndBrokenPoses) {
  PoseBuffer buffer;
  const base::StampNs second_ns = 1'000'000'000;
  EXPECT_TRUE(buffer.add(100 * second_ns, Pose::Identity()));
  EXPECT_FALSE(buffer.add(100 * second_ns, Pose::Identity()));
  EXPECT_FALSE(buffer.add(10 * second_ns, Pose::Identity()));
  Pose broken = Pose::Identity();
  broken.translation().x() = std::nan("");
  EXPECT_FALSE(buffer.add(101 * second_ns, broken));
  EXPECT_TRUE(buffer.add(101 * second_ns, Pose::Identity()));
}

TEST(PoseBuffer, ForgetsPosesOfAClockThatWasReset) {
  PoseBuffer buffer;
  for (int i = 0; i < 10; ++i) buffer.add(base::from_seconds(100.0 + 0.1 * i), Pose::Identity());
  for (int i = 0; i < 5; ++i) buffer.add(base::from_seconds(10.0 + 0.1 * i), Pose::Identity());
  EXPECT_TRUE(buffer.at(base::from_seconds(10.35)));
  EXPECT_FALSE(buffer.at(base::from_seconds(100.5)));
}

TEST(PoseBuffer, DoesNotInterpolateOverAGap) {
  PoseBuffer buffer;
  buffer.set_max_gap_ns(base::from_seconds(0.3));
  for (const double t : {1.0, 1.2, 1.7, 2.0}) buffer.add(base::from_seconds(t), from_position_yaw(Vec3(t, 0, 0), 0.0));
  EXPECT_TRUE(buffer.at(base::from_seconds(1.1)));
  EXPECT_TRUE(buffer.at(base::from_seconds(1.2)));  // the poses at both ends of the gap are known
  EXPECT_TRUE(buffer.at(base::from_seconds(1.7)));
  EXPECT_TRUE(buffer.at(base::from_seconds(1.9)));  // this gap is just short enough
  for (const double t : {1.21, 1.5, 1.69}) {
    EXPECT_FALSE(buffer.at(base::from_seconds(t)));
    EXPECT_EQ(buffer.gap_around(base::from_seconds(t)), base::from_seconds(1.7) - base::from_seconds(1.2));
  }
  EXPECT_FALSE(buffer.gap_around(base::from_seconds(1.1)));
  EXPECT_FALSE(buffer.gap_around(base::from_seconds(2.5)));  // a later pose may still cover this time
  buffer.set_max_gap_ns(std::nullopt);
  EXPECT_TRUE(buffer.at(base::from_seconds(1.5)));
}

TEST(PoseBuffer, AJumpOfTheClockLosesNoPose) {
  for (const double jump_s : {3600.0, -50.0, 5.0}) {
    PoseBuffer buffer;
    for (int i = 0; i < 10; ++i) buffer.add(base::from_seconds(100.0 + 0.1 * i), Pose::Identity());
    for (int i = 10; i < 15; ++i) buffer.add(base::from_seconds(100.0 + jump_s + 0.1 * i), Pose::Identity());
    EXPECT_TRUE(buffer.at(base::from_seconds(101.0 + jump_s))) << jump_s;
    EXPECT_TRUE(buffer.at(base::from_seconds(101.4 + jump_s))) << jump_s;
  }
}

TEST(PoseBuffer, OnePoseAheadLosesNoOther) {
  PoseBuffer buffer;
  for (int i = 0; i < 10; ++i) buffer.add(base::from_seconds(100.0 + 0.1 * i), Pose::Identity());
  EXPECT_FALSE(buffer.add(base::from_seconds(3700.0), Pose::Identity()));
  for (int i = 10; i < 20; ++i) EXPECT_TRUE(buffer.add(base::from_seconds(100.0 + 0.1 * i), Pose::Identity()));
  EXPECT_TRUE(buffer.at(base::from_seconds(100.05)));
  EXPECT_TRUE(buffer.at(base::from_seconds(101.85)));
  EXPECT_FALSE(buffer.at(base::from_seconds(3700.0)));
}

TEST(PoseBuffer, StaysBounded) {
  PoseBuffer buffer;
  const auto count = static_cast<base::StampNs>(PoseBuffer::kMaxPoses) + 10;
  for (base::StampNs i = 0; i < count; ++i) buffer.add(i, Pose::Identity());
  EXPECT_TRUE(buffer.is_before_all(9));
  EXPECT_FALSE(buffer.is_before_all(10));
}

}  // namespace
