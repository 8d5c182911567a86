// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>

#include "kernels/lanes.hpp"

using namespace voxnav::kernels::lanes;  // NOLINT: test

namespace {

void expect_lanes(Floats x, const float* expected) {
  for (int i = 0; i < kLanes; ++i) EXPECT_EQ(x[i], expected[i]) << i;
}

}  // namespace

TEST(Lanes, EachLaneIsComputedAsANumberOfItsOwn) {
  std::mt19937 rng(1);
  std::uniform_real_distribution<float> number(-1e6f, 1e6f);
  for (int trial = 0; trial < 200; ++trial) {
    float a[kLanes], b[kLanes], expected[4][kLanes];
    std::int32_t most = -2000000;
    for (int i = 0; i < kLanes; ++i) {
      a[i] = number(rng);
      b[i] = trial % 3 == 0 ? a[i] : number(rng);
      expected[0][i] = std::abs(a[i]);
      expected[1][i] = std::min(a[i], b[i]);
      expected[2][i] = std::max(a[i], b[i]);
      expected[3][i] = static_cast<float>(static_cast<std::int32_t>(a[i]));
      most = std::max(most, static_cast<std::int32_t>(a[i]));
    }
    const auto x = loaded<Floats>(a), y = loaded<Floats>(b);
    expect_lanes(absolute(x), expected[0]);
    expect_lanes(smaller(x, y), expected[1]);
    expect_lanes(larger(x, y), expected[2]);
    expect_lanes(floats(truncated(x)), expected[3]);
    EXPECT_EQ(highest(truncated(x)), most);
  }
}

TEST(Lanes, RootsAreThoseOfTheLibrary) {
  std::mt19937 rng(2);
  std::uniform_real_distribution<float> exponent(-80.0f, 80.0f);
  for (int trial = 0; trial < 2000; ++trial) {
    float numbers[kLanes], expected[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      numbers[i] = trial == 0 ? 0.0f : std::exp(exponent(rng));
      expected[i] = std::sqrt(numbers[i]);
    }
    expect_lanes(exact_root(loaded<Floats>(numbers)), expected);
  }
}

TEST(Lanes, ShufflingTakesLanesInTheGivenOrder) {
  std::mt19937 rng(3);
  for (int trial = 0; trial < 200; ++trial) {
    std::int32_t numbers[kLanes], order[kLanes], out[kLanes];
    for (int i = 0; i < kLanes; ++i) {
      numbers[i] = static_cast<std::int32_t>(rng());
      order[i] = static_cast<std::int32_t>(rng() % kLanes);
    }
    store(shuffled(loaded<Ints>(numbers), loaded<Ints>(order)), out);
    for (int i = 0; i < kLanes; ++i) EXPECT_EQ(out[i], numbers[order[i]]);
  }
}
