// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "pipeline/map_clock.hpp"

namespace {

using voxnav::pipeline::MapClock;
using Verdict = MapClock::Verdict;

voxnav::base::StampNs at(double t) { return voxnav::base::from_seconds(100.0 + t); }

TEST(MapClock, TheOnlySensorSetsTimeBackAtOnce) {
  MapClock clock(1);
  EXPECT_FALSE(clock.newest_ns());
  EXPECT_EQ(clock.add(0, at(10.0)), Verdict::kFollows);
  EXPECT_EQ(clock.add(0, at(9.5)), Verdict::kFollows);
  EXPECT_EQ(clock.newest_ns(), at(10.0));
  EXPECT_EQ(clock.add(0, at(1.0)), Verdict::kJumpedBack);
  EXPECT_EQ(clock.newest_ns(), at(1.0));
}

TEST(MapClock, ASensorWhoseClockLagsNeverSetsTimeBackWhileOthersDeliver) {
  for (const std::size_t lags : {0u, 1u}) {
    MapClock clock(2);
    for (int i = 0; i < 200; ++i) {
      EXPECT_EQ(clock.add(1 - lags, at(0.1 * i)), Verdict::kFollows);
      EXPECT_EQ(clock.add(lags, at(0.1 * i - 5.0)), Verdict::kBehindOthers);
    }
    EXPECT_EQ(clock.newest_ns(), at(19.9));
  }
}

TEST(MapClock, ASensorThatDiedDoesNotHoldTimeForEver) {
  MapClock clock(2);
  clock.add(1, at(10.0));
  clock.add(0, at(10.05));
  int num_behind = 0;
  while (clock.add(0, at(0.1 * num_behind)) == Verdict::kBehindOthers) ++num_behind;
  EXPECT_EQ(num_behind, 11);
  EXPECT_EQ(clock.newest_ns(), at(1.1));
}

TEST(MapClock, TimeIsSetBackOnceAllSensorsSayIt) {
  MapClock clock(2);
  clock.add(0, at(10.0));
  clock.add(1, at(10.0));
  int num_jumps = 0;
  for (int i = 0; i < 30; ++i) {
    for (const std::size_t sensor : {0u, 1u}) num_jumps += clock.add(sensor, at(0.1 * i)) == Verdict::kJumpedBack;
  }
  EXPECT_EQ(num_jumps, 1);
  EXPECT_EQ(clock.newest_ns(), at(2.9));
}

TEST(MapClock, TheFirstSensorThatDeliversLeads) {
  MapClock clock(3);
  EXPECT_TRUE(clock.leads(1, at(0.0)));
  EXPECT_FALSE(clock.leads(2, at(0.05)));
  EXPECT_TRUE(clock.leads(0, at(0.06)));
  EXPECT_FALSE(clock.leads(1, at(0.1)));
  EXPECT_TRUE(clock.leads(0, at(0.16)));
  EXPECT_FALSE(clock.leads(1, at(1.1)));
  EXPECT_TRUE(clock.leads(1, at(1.2)));  // the first died
  EXPECT_FALSE(clock.leads(2, at(1.25)));
  EXPECT_TRUE(clock.leads(0, at(1.3)));  // and is back
}

}  // namespace
