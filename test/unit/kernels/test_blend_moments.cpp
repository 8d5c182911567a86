// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>
#include <random>

#include "instruction_sets.hpp"
#include "kernels/blend_moments.hpp"

using namespace voxnav;  // NOLINT: test

namespace {

struct Stored {
  std::array<std::int16_t, 8> covariance{}, means{};
  kernels::StoredMoments view() { return {covariance.data(), means.data()}; }
};

kernels::MomentUpdate random_update(std::mt19937* rng) {
  std::uniform_real_distribution<float> offset(-0.5f, 0.5f), share(0.0f, 1.0f);
  kernels::MomentUpdate out;
  for (float& x : out.mean) x = offset(*rng);
  for (float& x : out.covariance) x = 0.6f * offset(*rng);
  out.share = 1.0f / static_cast<float>(1 + (*rng)() % 50);
  out.recent_share = share(*rng);
  return out;
}

}  // namespace

TEST(BlendMoments, EqualsTheReferenceAndWritesNothingBeyondItsOutput) {
  test::with_every_instruction_set([] {
    std::mt19937 rng(3);
    for (int trial = 0; trial < 50; ++trial) {
      Stored stored, expected;
      stored.covariance[6] = stored.means[6] = 1234;
      stored.covariance[7] = stored.means[7] = -4321;
      expected = stored;
      for (int scan = 0; scan < 60; ++scan) {
        const kernels::MomentUpdate update = random_update(&rng);
        kernels::blend_moments(update, stored.view());
        kernels::reference::blend_moments(update, expected.view());
        ASSERT_EQ(stored.means, expected.means);
        ASSERT_EQ(stored.covariance, expected.covariance);
      }
    }
  });
}

TEST(BlendMoments, OfTheSamePointsAreTheirMeanAndCovariance) {
  Stored stored;
  kernels::MomentUpdate update{{0.25f, -0.125f, 0.4f}, {0.01f, 0.002f, -0.003f, 0.02f, 0.0f, 0.005f}, 1.0f, 1.0f};
  for (int scan = 1; scan <= 20; ++scan) {
    update.share = update.recent_share = 1.0f / static_cast<float>(scan);
    kernels::blend_moments(update, stored.view());
  }
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(static_cast<float>(stored.means[i]) * 0.5f / kernels::kMeanUnits, update.mean[i % 3], 1e-4f);
    EXPECT_NEAR(static_cast<float>(stored.covariance[i]) / kernels::kCovarianceUnits, update.covariance[i], 1e-4f);
  }
}
