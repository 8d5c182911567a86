// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <vector>

#include "voxnav/pipeline/sweep_locator.hpp"

using namespace voxnav;  // NOLINT: test

TEST(Deskew, PointsOfAStaticWorldSeenInMotionAgreeAfterwards) {
  pipeline::SweepMotion motion;
  motion.T_O_L_start = geometry::from_position_yaw({1.0, 2.0, 3.0}, 0.2);
  motion.T_O_L_end = geometry::from_position_yaw({1.8, 2.2, 3.1}, 0.5);
  motion.duration_ns = 100000000;
  const geometry::Vec3 landmark(10.0, -4.0, 1.0);
  std::vector<float> points;
  std::vector<std::uint32_t> times;
  for (int i = 0; i <= 1000; ++i) {
    const geometry::Pose T_O_L = geometry::interpolate(motion.T_O_L_start, motion.T_O_L_end, i / 1000.0);
    const geometry::Vec3f seen = (T_O_L.inverse() * landmark).cast<float>();
    points.insert(points.end(), {seen.x(), seen.y(), seen.z(), 7.0f});
    times.push_back(static_cast<std::uint32_t>(i) * 100000);
  }
  pipeline::deskew({points.data(), times.size(), 4}, times, motion);
  const geometry::Pose T_O_middle = pipeline::middle_of(motion);
  for (std::size_t i = 0; i < times.size(); ++i) {
    const geometry::Vec3f p(points[4 * i], points[4 * i + 1], points[4 * i + 2]);
    EXPECT_LT((T_O_middle * p.cast<double>() - landmark).norm(), 0.05);
    EXPECT_EQ(points[4 * i + 3], 7.0f);
  }
}

TEST(Deskew, WithoutDurationNothingMoves) {
  std::vector<float> points{1, 2, 3};
  pipeline::SweepMotion motion;
  motion.T_O_L_end.translation().x() = 5.0;
  pipeline::deskew(geometry::view_of_rows(&points), {0}, motion);
  EXPECT_EQ(points, (std::vector<float>{1, 2, 3}));
}

TEST(Deskew, EveryPointNeedsATime) {
  std::vector<float> points{1, 2, 3, 4, 5, 6};
  EXPECT_THROW(pipeline::deskew(geometry::view_of_rows(&points), {0}, {}), std::invalid_argument);
}
