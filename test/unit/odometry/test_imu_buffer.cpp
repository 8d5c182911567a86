// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "odometry/imu_buffer.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using odometry::ImuBuffer;

ImuBuffer spinning(const Vec3& rate, int first_ms, int last_ms) {
  ImuBuffer buffer;
  for (int ms = first_ms; ms <= last_ms; ms += 5) buffer.add({base::StampNs{ms} * 1000000, rate, Vec3(0, 0, 9.81)});
  return buffer;
}

TEST(ImuBuffer, IntegratesConstantRatesExactlyBetweenSamples) {
  const Vec3 rate(0.3, -0.5, 2.0);
  const ImuBuffer buffer = spinning(rate, 0, 1000);
  const auto turned = buffer.rotation(103000000, 407000000, Vec3::Zero(), 0.02);
  ASSERT_TRUE(turned);
  EXPECT_LT((odometry::log_so3(*turned) - rate * 0.304).norm(), 1e-9);
  const auto back = buffer.rotation(407000000, 103000000, Vec3::Zero(), 0.02);
  EXPECT_LT((odometry::log_so3(*back) + rate * 0.304).norm(), 1e-9);
}

TEST(ImuBuffer, IntegratesChangingRatesToSecondOrder) {
  ImuBuffer buffer;
  for (int ms = 0; ms <= 1000; ms += 5) {
    buffer.add({base::StampNs{ms} * 1000000, Vec3(0, 0, std::sin(ms * 1e-3 * 6.0)), Vec3::Zero()});
  }
  const auto turned = buffer.rotation(0, 700000000, Vec3::Zero(), 0.02);
  EXPECT_NEAR(odometry::log_so3(*turned).z(), (1 - std::cos(4.2)) / 6.0, 1e-4);
}

TEST(ImuBuffer, SubtractsTheBias) {
  const auto turned = spinning(Vec3(0, 0, 1.1), 0, 1000).rotation(0, 500000000, Vec3(0, 0, 0.1), 0.02);
  EXPECT_NEAR(odometry::log_so3(*turned).z(), 0.5, 1e-9);
}

TEST(ImuBuffer, ReturnsNothingForTimesWithoutSamples) {
  const ImuBuffer buffer = spinning(Vec3::UnitZ(), 100, 500);
  EXPECT_FALSE(buffer.rotation(0, 300000000, Vec3::Zero(), 0.02));
  EXPECT_FALSE(buffer.rotation(300000000, 900000000, Vec3::Zero(), 0.02));
  EXPECT_FALSE(buffer.rotation(700000000, 900000000, Vec3::Zero(), 0.02));
  EXPECT_FALSE(ImuBuffer().rotation(0, 1, Vec3::Zero(), 0.02));
  EXPECT_TRUE(buffer.rotation(300000000, 510000000, Vec3::Zero(), 0.02));
}

TEST(ImuBuffer, RefusesAGapInTheMiddle) {
  ImuBuffer buffer = spinning(Vec3::UnitZ(), 0, 200);
  for (int ms = 300; ms <= 500; ms += 5) buffer.add({base::StampNs{ms} * 1000000, Vec3::UnitZ(), Vec3::Zero()});
  EXPECT_FALSE(buffer.rotation(100000000, 400000000, Vec3::Zero(), 0.05));
  EXPECT_TRUE(buffer.rotation(100000000, 400000000, Vec3::Zero(), 0.15));
}

TEST(ImuBuffer, DropsBadSamplesAndStaysBounded) {
  ImuBuffer buffer;
  EXPECT_EQ(buffer.add({10, Vec3::Zero(), Vec3::Zero()}), ImuBuffer::AddResult::kAdded);
  EXPECT_EQ(buffer.add({10, Vec3::Zero(), Vec3::Zero()}), ImuBuffer::AddResult::kNotNewer);
  EXPECT_EQ(buffer.add({20, Vec3(NAN, 0, 0), Vec3::Zero()}), ImuBuffer::AddResult::kNotFinite);
  for (int i = 0; i < 20000; ++i) buffer.add({100 + i, Vec3::Zero(), Vec3::Zero()});
  EXPECT_EQ(buffer.size(), ImuBuffer::kMaxSamples);
}

TEST(ImuBuffer, ASampleFarAheadDoesNotSilenceTheOthers) {
  for (const double lead_s : {0.3, 5.0, 3600.0}) {
    ImuBuffer buffer = spinning(Vec3::UnitZ(), 0, 200);
    const base::StampNs lead_ns = base::from_seconds(lead_s);
    EXPECT_EQ(buffer.add({200000000 + lead_ns, Vec3::UnitZ(), Vec3::Zero()}), ImuBuffer::AddResult::kOtherClock);
    for (int ms = 205; ms <= 400; ms += 5) {
      EXPECT_EQ(buffer.add({base::StampNs{ms} * 1000000, Vec3::UnitZ(), Vec3::Zero()}), ImuBuffer::AddResult::kAdded);
    }
    const auto turned = buffer.rotation(100000000, 400000000, Vec3::Zero(), 0.02);
    ASSERT_TRUE(turned);
    EXPECT_NEAR(odometry::log_so3(*turned).z(), 0.3, 1e-9);
    EXPECT_EQ(buffer.stamp_counts().stray, 1u);
  }
}

TEST(ImuBuffer, FollowsAClockThatIsReset) {
  for (const double jump_s : {3600.0, -50.0}) {
    const base::StampNs jump_ns = base::from_seconds(jump_s);
    ImuBuffer buffer = spinning(Vec3::UnitZ(), 0, 200);
    int num_refused = 0, num_jumps = 0;
    for (int ms = 205; ms <= 600; ms += 5) {
      const auto result = buffer.add({jump_ns + base::StampNs{ms} * 1000000, Vec3::UnitZ(), Vec3::Zero()});
      num_refused += result == ImuBuffer::AddResult::kOtherClock;
      num_jumps += result == ImuBuffer::AddResult::kAddedOnNewClock;
    }
    EXPECT_EQ(num_refused, ImuBuffer::kNumConfirming - 1);
    EXPECT_EQ(num_jumps, 1);
    EXPECT_TRUE(buffer.rotation(jump_ns + 300000000, jump_ns + 600000000, Vec3::Zero(), 0.02));
    EXPECT_FALSE(buffer.rotation(100000000, 200000000, Vec3::Zero(), 0.02));
  }
}

TEST(So3, LogInvertsExp) {
  for (const Vec3& v : {Vec3(0, 0, 0), Vec3(1e-12, 0, 0), Vec3(0.1, -0.2, 0.3), Vec3(0, 3.1, 0)}) {
    EXPECT_LT((odometry::log_so3(odometry::exp_so3(v)) - v).norm(), 1e-9);
  }
}

}  // namespace
