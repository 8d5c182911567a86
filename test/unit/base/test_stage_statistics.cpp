// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/base/stage_statistics.hpp"

using voxnav::base::DurationHistogram;

TEST(DurationHistogram, QuantilesAreWithinABucketOfTheTruth) {
  DurationHistogram histogram;
  for (int i = 1; i <= 1000; ++i) histogram.add(i * 0.1);
  EXPECT_EQ(histogram.count(), 1000u);
  EXPECT_NEAR(histogram.mean_ms(), 50.05, 1e-9);
  EXPECT_EQ(histogram.max_ms(), 100.0);
  EXPECT_NEAR(histogram.quantile_ms(0.5), 50.0, 50.0 * 0.08);
  EXPECT_NEAR(histogram.quantile_ms(0.99), 99.0, 99.0 * 0.08);
  EXPECT_LE(histogram.quantile_ms(1.0), 100.0);
}

TEST(DurationHistogram, ExtremesStayBounded) {
  DurationHistogram histogram;
  EXPECT_EQ(histogram.quantile_ms(0.99), 0.0);
  histogram.add(0.0);
  histogram.add(1e12);
  EXPECT_EQ(histogram.max_ms(), 1e12);
  EXPECT_EQ(histogram.count(), 2u);
}

TEST(StageTimer, AddsOneSamplePerLifetime) {
  voxnav::base::StageStatistics stage;
  { voxnav::base::StageTimer timer(&stage); }
  { voxnav::base::StageTimer timer(&stage); }
  EXPECT_EQ(stage.wall.count(), 2u);
  EXPECT_EQ(stage.cpu.count(), 2u);
  EXPECT_GT(voxnav::base::process_usage().rss_bytes, 0u);
}
