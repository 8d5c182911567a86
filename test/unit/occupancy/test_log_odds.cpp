// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "occupancy/byte_ops.hpp"
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
  EXPECT_EQ(levels.of(scale.prior + scale.hit), containers::State::kUnknown);
  EXPECT_EQ(levels.of(scale.prior + scale.hit + 1), containers::State::kOccupied);
  EXPECT_EQ(levels.of(scale.prior - scale.miss), containers::State::kUnknown);
  EXPECT_EQ(levels.of(scale.prior - 2 * scale.miss), containers::State::kFree);
}

TEST(ByteOps, VectorAndPlainSubtractionAgree) {
  std::mt19937_64 rng(5);
  for (int trial = 0; trial < 100; ++trial) {
    std::array<std::uint8_t, 64> a{};
    for (auto& v : a) v = static_cast<std::uint8_t>(rng());
    auto b = a;
    const std::uint64_t mask = rng() & rng();
    const occupancy::Subtraction by{11, 40, 90};
    auto c = a;
    const auto plain = occupancy::subtract_where_plain(b.data(), mask, by);
    const auto expect_same = [&](const occupancy::Subtracted& done, const std::array<std::uint8_t, 64>& cells) {
      EXPECT_EQ(done.any_changed, plain.any_changed);
      EXPECT_EQ(done.crossed_free, plain.crossed_free);
      EXPECT_EQ(done.crossed_occupied, plain.crossed_occupied);
      EXPECT_EQ(cells, b);
    };
    expect_same(occupancy::subtract_where(a.data(), mask, by), a);
    if (base::is_wide()) expect_same(occupancy::subtract_where_wide(c.data(), mask, by), c);
  }
}

TEST(ByteOps, FindsTheCellsThatAreAtLeastSoMuch) {
  std::uint8_t cells[64];
  for (int i = 0; i < 64; ++i) cells[i] = static_cast<std::uint8_t>(i * 41);
  for (const int limit : {0, 1, 41, 127, 128, 200, 255, 256}) {
    const std::uint64_t bits = voxnav::occupancy::bits_at_least(cells, limit);
    for (int i = 0; i < 64; ++i) EXPECT_EQ((bits >> i) & 1u, cells[i] >= limit ? 1u : 0u) << i << " " << limit;
  }
}

TEST(ByteOps, TransposesBitMatrices) {
  std::mt19937_64 rng(6);
  for (int trial = 0; trial < 100; ++trial) {
    std::array<std::uint16_t, 16> in{};
    for (auto& row : in) row = static_cast<std::uint16_t>(rng() & rng());
    std::array<std::uint16_t, 16> out{};
    occupancy::transpose_16(in.data(), out.data());
    for (int k = 0; k < 16; ++k) {
      for (int i = 0; i < 16; ++i) EXPECT_EQ((out[k] >> i) & 1, (in[i] >> k) & 1);
    }
  }
}

TEST(LocalMapConfig, WindowsThatDoNotFitMemoryAreRefusedWithTheFigure) {
  LocalMapConfig config;
  config.resolution_m = 0.02;
  const auto problems = base::problems_of(config);
  ASSERT_EQ(problems.size(), 1u);
  EXPECT_NE(problems[0].find("MB"), std::string::npos);
  EXPECT_NE(problems[0].find("0.02"), std::string::npos);
}
