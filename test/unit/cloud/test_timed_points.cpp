// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>

#include "raw_cloud.hpp"
#include "voxnav/cloud/timed_points.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using test::RawCloud;

TEST(TimedPoints, KeepsEveryPointInOrder) {
  RawCloud c(2, 2, 29, test::gazebo_fields());
  for (std::size_t i = 0; i < 4; ++i) {
    c.set_xyz(i, static_cast<float>(i), std::nanf(""), 2.0F);
    c.set(i, "t", static_cast<std::uint32_t>(i * 25'000'000));
  }
  const cloud::TimedPoints points = cloud::timed_points(c.view(5'000'000'000));
  ASSERT_EQ(points.positions.size(), 4u);
  EXPECT_EQ(points.positions[3].x(), 3.0F);
  EXPECT_FLOAT_EQ(points.times_s[3], 0.075F);
  EXPECT_EQ(points.sweep_start_ns, 5'000'000'000);
}

TEST(TimedPoints, CountsFromTheSweepStartWhenTheStampIsItsEnd) {
  auto fields = test::xyzi_fields();
  fields.push_back({"time", 16, cloud::FieldType::kFloat32, 1});
  RawCloud c(1, 3, 20, fields);
  for (std::size_t i = 0; i < 3; ++i) c.set(i, "time", -0.1F + 0.05F * static_cast<float>(i));
  const cloud::TimedPoints points = cloud::timed_points(c.view(1'000'000'000));
  EXPECT_NEAR(static_cast<double>(points.sweep_start_ns), 9e8, 10);
  EXPECT_FLOAT_EQ(points.times_s[0], 0.0F);
  EXPECT_NEAR(points.times_s[2], 0.1F, 1e-6F);
}

TEST(TimedPoints, CloudsWithoutTimesOrPointsHaveNoTimes) {
  EXPECT_TRUE(cloud::timed_points(test::xyzi_cloud(1, 5).view()).times_s.empty());
  EXPECT_TRUE(cloud::timed_points(cloud::RawCloudView(cloud::CloudLayout(), nullptr, 0)).positions.empty());
}

}  // namespace
