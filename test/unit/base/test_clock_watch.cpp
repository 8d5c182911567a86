// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "base/clock_watch.hpp"

namespace {

using voxnav::base::ClockWatch;
using voxnav::base::from_seconds;
using voxnav::base::StampNs;
using Verdict = ClockWatch::Verdict;

constexpr double kHour_s = 3600.0;

/// Both sides watched, as for an IMU.
ClockWatch strict() { return ClockWatch({from_seconds(1.0), from_seconds(1.0), 3}); }

Verdict add(ClockWatch* watch, double stamp_s) { return watch->add(from_seconds(stamp_s)); }

TEST(ClockWatch, TakesRisingStampsAndRefusesLateOnes) {
  ClockWatch watch = strict();
  EXPECT_EQ(add(&watch, 100.0), Verdict::kNext);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kNext);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kLate);
  EXPECT_EQ(add(&watch, 99.5), Verdict::kLate);
  EXPECT_EQ(add(&watch, 100.2), Verdict::kNext);
}

TEST(ClockWatch, OneStrayStampChangesNothing) {
  for (const double stray_s : {100.0 + kHour_s, 100.0 - kHour_s, 0.0}) {
    ClockWatch watch = strict();
    add(&watch, 100.0);
    EXPECT_EQ(add(&watch, stray_s), Verdict::kStray);
    EXPECT_EQ(*watch.newest_ns(), from_seconds(100.0));
    EXPECT_EQ(add(&watch, 100.1), Verdict::kNext);
  }
}

TEST(ClockWatch, AFirstStampThatIsWrongIsGivenUp) {
  ClockWatch watch = strict();
  EXPECT_EQ(add(&watch, kHour_s), Verdict::kNext);
  EXPECT_EQ(add(&watch, 100.0), Verdict::kStray);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kStray);
  EXPECT_EQ(add(&watch, 100.2), Verdict::kNewClock);
  EXPECT_EQ(add(&watch, 100.3), Verdict::kNext);
}

TEST(ClockWatch, ALastingJumpEitherWayIsANewClock) {
  for (const double jump_s : {kHour_s, -50.0}) {
    ClockWatch watch = strict();
    add(&watch, 100.0);
    EXPECT_EQ(add(&watch, 100.0 + jump_s), Verdict::kStray);
    EXPECT_EQ(add(&watch, 100.1 + jump_s), Verdict::kStray);
    EXPECT_EQ(add(&watch, 100.2 + jump_s), Verdict::kNewClock);
    EXPECT_EQ(add(&watch, 100.3 + jump_s), Verdict::kNext);
  }
}

TEST(ClockWatch, StrayStampsThatDoNotFollowEachOtherConfirmNothing) {
  ClockWatch watch = strict();
  add(&watch, 100.0);
  EXPECT_EQ(add(&watch, 10.0), Verdict::kStray);
  EXPECT_EQ(add(&watch, 10.0), Verdict::kStray);  // the same message again
  EXPECT_EQ(add(&watch, 9.9), Verdict::kStray);   // falling
  EXPECT_EQ(add(&watch, 20.0), Verdict::kStray);  // far from the one before
  EXPECT_EQ(add(&watch, 20.1), Verdict::kStray);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kNext);  // the old clock still runs
  EXPECT_EQ(add(&watch, 20.2), Verdict::kStray);
  EXPECT_EQ(add(&watch, 20.3), Verdict::kStray);
}

TEST(ClockWatch, WithoutALimitAheadEveryGapIsBelieved) {
  ClockWatch watch({from_seconds(1.0), std::nullopt, 3});
  add(&watch, 100.0);
  EXPECT_EQ(add(&watch, 100.0 + kHour_s), Verdict::kNext);
}

TEST(ClockWatch, ResetForgetsTheClock) {
  ClockWatch watch = strict();
  add(&watch, kHour_s);
  add(&watch, 1.0);
  watch.reset();
  EXPECT_FALSE(watch.newest_ns());
  EXPECT_EQ(add(&watch, 1.0), Verdict::kNext);
}

}  // namespace
