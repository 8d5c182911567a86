// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>

#include "pipeline/load_control.hpp"

using voxnav::pipeline::LoadControl;
using voxnav::pipeline::LoadControlConfig;

TEST(LoadControl, ThinsOutStepByStepAndRecoversSlowly) {
  LoadControlConfig config;
  config.max_decimation = 6;
  LoadControl load(config);
  EXPECT_EQ(load.decimation(), 1);
  const int coarser[] = {2, 4, 6, 6};
  for (const int expected : coarser) {
    load.add(0.09, 0.1);
    EXPECT_EQ(load.decimation(), expected);
  }
  for (int i = 0; i < 100; ++i) load.add(0.05, 0.1);
  EXPECT_EQ(load.decimation(), 6) << "twice the points would not fit";
  for (int i = 0; i < 19; ++i) load.add(0.01, 0.1);
  EXPECT_EQ(load.decimation(), 6);
  load.add(0.01, 0.1);
  EXPECT_EQ(load.decimation(), 3);
  for (int i = 0; i < 60; ++i) load.add(0.01, 0.1);
  EXPECT_EQ(load.decimation(), 1);
}

TEST(LoadControl, IgnoresUnusableDurations) {
  LoadControl load({});
  load.add(1.0, 0.0);
  load.add(1.0, -1.0);
  load.add(std::numeric_limits<double>::infinity(), 0.1);
  load.add(-1.0, 0.1);
  EXPECT_EQ(load.decimation(), 1);
}

TEST(LoadControl, KeepsEveryNthRow) {
  LoadControl load({});
  std::vector<int> rows{0, 1, 10, 11, 20, 21, 30, 31, 40, 41};
  load.thin_out(2, &rows);
  EXPECT_EQ(rows.size(), 10u);
  load.add(0.2, 0.1);
  load.thin_out(2, &rows);
  EXPECT_EQ(rows, (std::vector<int>{0, 1, 20, 21, 40, 41}));
}
