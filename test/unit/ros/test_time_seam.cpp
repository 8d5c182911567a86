// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav_ros/time_seam.hpp"

using voxnav_ros::InputClock;
using voxnav_ros::SteadyClock;

TEST(InputClock, IsTheNewestStampOfAnyInput) {
  InputClock clock;
  const double before_s = clock.now_s();
  EXPECT_EQ(clock.now_s(), before_s);
  clock.reach(ros::Time(100, 0));
  EXPECT_DOUBLE_EQ(clock.now_s(), 100.0);
  clock.reach(ros::Time(100, 100000000));
  EXPECT_DOUBLE_EQ(clock.now_s(), 100.1);
}

TEST(InputClock, StandsStillWhileTheNodeWorks) {
  InputClock clock;
  clock.reach(ros::Time(100, 0));
  const double begin_s = clock.now_s();
  const ros::SteadyTime work_end = ros::SteadyTime::now() + ros::WallDuration(0.002);
  while (ros::SteadyTime::now() < work_end) continue;
  EXPECT_EQ(clock.now_s() - begin_s, 0.0);
}

TEST(InputClock, DoesNotGoBackForLateInputs) {
  InputClock clock;
  clock.reach(ros::Time(100, 0));
  clock.reach(ros::Time(99, 200000000));
  EXPECT_DOUBLE_EQ(clock.now_s(), 100.0);
}

TEST(InputClock, FollowsASimulationThatRestarts) {
  InputClock clock;
  clock.reach(ros::Time(100, 0));
  clock.reach(ros::Time(1, 0));
  EXPECT_DOUBLE_EQ(clock.now_s(), 1.0);
  clock.reach(ros::Time(1, 500000000));
  EXPECT_DOUBLE_EQ(clock.now_s(), 1.5);
}

TEST(SteadyClock, DoesNotDependOnTheInputs) {
  SteadyClock clock;
  const double begin_s = clock.now_s();
  clock.reach(ros::Time(4000000000, 0));
  const ros::SteadyTime work_end = ros::SteadyTime::now() + ros::WallDuration(0.002);
  while (ros::SteadyTime::now() < work_end) continue;
  const double passed_s = clock.now_s() - begin_s;
  EXPECT_GE(passed_s, 0.002);
  EXPECT_LT(passed_s, 1e6);
}
