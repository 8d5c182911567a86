// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "pipeline/sweep_queue.hpp"

namespace {

using namespace voxnav;  // NOLINT: test
using pipeline::SensorConfig;
using pipeline::SweepFate;
using pipeline::SweepQueue;
using pipeline::WaitingSweep;

WaitingSweep sweep_at(double t) {
  WaitingSweep out;
  out.sweep.start_ns = out.sweep.stamp_ns = base::from_seconds(t);
  return out;
}

/// How many of the sweeps at some times are left out for their rate.
int num_surplus(double max_rate_hz, const std::vector<double>& times_s) {
  SensorConfig config;
  config.max_rate_hz = max_rate_hz;
  SweepQueue queue(config);
  for (const double t : times_s) queue.push(sweep_at(t));
  int count = 0;
  while (!queue.empty()) {
    const WaitingSweep waiting = queue.pop();
    if (!waiting.drop) continue;
    EXPECT_EQ(waiting.drop->fate, SweepFate::kSurplus);
    ++count;
  }
  return count;
}

std::vector<double> even(double rate_hz, int count, double jitter_s = 0.0) {
  std::vector<double> out;
  out.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) out.push_back(50.0 + i / rate_hz + (i % 2 ? jitter_s : -jitter_s));
  return out;
}

TEST(SweepQueue, KeepsNoMoreThanTheRateThatIsAllowed) {
  EXPECT_EQ(num_surplus(1000.0, even(30.0, 300)), 0);
  EXPECT_NEAR(num_surplus(10.0, even(30.0, 300)), 200, 1);
  EXPECT_NEAR(num_surplus(10.0, even(30.0, 300, 0.004)), 200, 1);  // stamps that tremble cost no rate
  EXPECT_NEAR(num_surplus(12.0, even(30.0, 300)), 180, 1);
  for (const double jitter_s : {0.004, -0.004}) EXPECT_NEAR(num_surplus(10.0, even(10.0, 300, jitter_s)), 0, 1);
}

TEST(SweepQueue, KeepsTheFirstSweepOfAClockThatWasSetBackAndAfterAPause) {
  EXPECT_EQ(num_surplus(10.0, {50.0, 50.05, 50.1, 70.0, 70.05, 20.0, 20.05, 20.1}), 3);
}

}  // namespace
