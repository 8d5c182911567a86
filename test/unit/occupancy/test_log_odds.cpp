// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "occupancy/log_odds.hpp"

using namespace voxnav;  // NOLINT: test
using occupancy::LocalMapConfig;
using occupancy::LogOddsScale;
using occupancy::StateLevels;

TEST(LogOdds, DefaultsTakeTheScansOfTheReferenceTable) {
  const LocalMapConfig config;
  const LogOddsScale scale = LogOddsScale::from(config);
  const auto counts = transitions_of(scale, StateLevels(scale, config.free_threshold, config.occupied_threshold));
  EXPECT_EQ(counts.hits_unknown_to_occupied, 2);
  EXPECT_EQ(counts.misses_unknown_to_free, 3);
  EXPECT_EQ(counts.misses_full_to_not_occupied, 6);
  EXPECT_EQ(counts.misses_full_to_free, 11);
  EXPECT_EQ(counts.hits_empty_to_occupied, 4);
}

TEST(LogOdds, ByteScaleCountsLikeExactArithmetic) {
  std::mt19937 rng(3);
  const auto uniform = [&](double low, double high) { return std::uniform_real_distribution<double>(low, high)(rng); };
  int faithful = 0;
  constexpr int kTrials = 200;
  for (int i = 0; i < kTrials; ++i) {
    LocalMapConfig config;
    config.prob_hit = uniform(0.6, 0.9);
    config.prob_miss = uniform(0.3, 0.45);
    config.occupied_threshold = uniform(0.5, 0.9);
    config.free_threshold = uniform(0.2, 0.5);
    const LogOddsScale scale = LogOddsScale::from(config);
    const auto counts = transitions_of(scale, StateLevels(scale, config.free_threshold, config.occupied_threshold));
    const int wrong = mismatch(counts, ideal_transitions(config));
    EXPECT_LE(wrong, 1);
    faithful += wrong == 0 ? 1 : 0;
  }
  EXPECT_GE(faithful, kTrials * 95 / 100);
}

TEST(LogOdds, ThresholdsThemselvesAreUnknown) {
  LocalMapConfig config;
  config.occupied_threshold = config.prob_hit;
  config.free_threshold = config.prob_miss;
  const LogOddsScale scale = LogOddsScale::from(config);
  const StateLevels levels(scale, config.free_threshold, config.occupied_threshold);
  EXPECT_EQ(levels.of(scale.prior + scale.hit), containers::VoxelState::kUnknown);
  EXPECT_EQ(levels.of(scale.prior + scale.hit + 1), containers::VoxelState::kOccupied);
  EXPECT_EQ(levels.of(scale.prior - scale.miss), containers::VoxelState::kUnknown);
  EXPECT_EQ(levels.of(scale.prior - 2 * scale.miss), containers::VoxelState::kFree);
}

TEST(LocalMapConfig, WindowsThatDoNotFitMemoryAreRefusedWithTheFigure) {
  LocalMapConfig config;
  config.resolution_m = 0.02;
  const auto problems = base::problems_of(config);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("MB"), std::string::npos);
  EXPECT_NE(problems[0].find("0.02"), std::string::npos);
}
