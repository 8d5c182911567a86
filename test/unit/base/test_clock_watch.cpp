// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/base/clock_watch.hpp"

namespace {

using voxnav::base::ClockWatch;
using voxnav::base::from_seconds;
using voxnav::base::StampNs;
using Verdict = voxnav::base::StampVerdict;

constexpr double kHour_s = 3600.0;

/// Returns a watch with limits for jumps ahead and back, as an IMU has.
ClockWatch strict() { return ClockWatch({from_seconds(1.0), from_seconds(1.0), 3}); }

Verdict add(ClockWatch* watch, double stamp_s) { return watch->add(from_seconds(stamp_s)); }

TEST(ClockWatch, TakesRisingStampsAndRefusesLateOnes) {
  ClockWatch watch = strict();
  EXPECT_EQ(add(&watch, 100.0), Verdict::kNext);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kNext);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kRepeated);
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

TEST(ClockWatch, AWrongFirstStampIsReplaced) {
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
  EXPECT_EQ(add(&watch, 10.0), Verdict::kStray);  // the stamp is repeated
  EXPECT_EQ(add(&watch, 9.9), Verdict::kStray);   // the stamp falls
  EXPECT_EQ(add(&watch, 20.0), Verdict::kStray);  // the stamp is far from the one before
  EXPECT_EQ(add(&watch, 20.1), Verdict::kStray);
  EXPECT_EQ(add(&watch, 100.1), Verdict::kNext);  // the stamp continues the old clock
  EXPECT_EQ(add(&watch, 20.2), Verdict::kStray);
  EXPECT_EQ(add(&watch, 20.3), Verdict::kStray);
}

TEST(ClockWatch, EveryThirdStampOfASourceSlowerThanTheLimitIsANewClock) {
  ClockWatch watch = strict();
  add(&watch, 100.0);
  for (const double stamp_s : {105.0, 120.0}) {
    EXPECT_EQ(add(&watch, stamp_s), Verdict::kStray);
    EXPECT_EQ(add(&watch, stamp_s + 5.0), Verdict::kStray);
    EXPECT_EQ(add(&watch, stamp_s + 10.0), Verdict::kNewClock);
  }
}

TEST(ClockWatch, WithoutALimitAheadEveryGapIsAccepted) {
  ClockWatch watch({from_seconds(1.0), std::nullopt, 3});
  add(&watch, 100.0);
  EXPECT_EQ(add(&watch, 100.0 + kHour_s), Verdict::kNext);
}

TEST(ClockWatch, CountsStampsByTheirVerdict) {
  ClockWatch watch = strict();
  EXPECT_EQ(voxnav::base::describe(watch.counts()), "");
  for (const double stamp_s : {100.0, 100.1, 100.1, 100.05, kHour_s, 100.2, 5.0, 5.1, 5.2}) add(&watch, stamp_s);
  const voxnav::base::StampCounts& counts = watch.counts();
  EXPECT_EQ(counts.next, 3u);
  EXPECT_EQ(counts.repeated, 1u);
  EXPECT_EQ(counts.late, 1u);
  EXPECT_EQ(counts.stray, 3u);
  EXPECT_EQ(counts.new_clocks, 1u);
  EXPECT_EQ(counts.stuck_clocks, 0u);
  EXPECT_EQ(voxnav::base::describe(counts),
            "1 repeated, 1 late, 3 alone on another clock, 1 from which on the clock was another");
}

TEST(ClockWatch, AClockThatStandsStillIsStuckOnceForEachTime) {
  ClockWatch watch = strict();
  for (int time = 0; time < 2; ++time) {
    for (int i = 0; i < 25; ++i) {
      add(&watch, 100.0 + time);
      EXPECT_EQ(watch.is_stuck(), i >= 9);
    }
  }
  EXPECT_EQ(add(&watch, 101.1), Verdict::kNext);
  EXPECT_FALSE(watch.is_stuck());
  EXPECT_EQ(watch.counts().stuck_clocks, 2u);
  EXPECT_EQ(watch.counts().longest_repeat, 24u);
  EXPECT_NE(voxnav::base::describe(watch.counts()).find("stood still 2 times, for up to 25 messages"),
            std::string::npos);
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
