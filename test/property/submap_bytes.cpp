// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "resealed.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Vec3;
using submap::Submap;

namespace {

std::shared_ptr<Submap> random_submap(unsigned seed) {
  submap::SubmapConfig config;
  config.max_surface_points = 50;
  return Submap::from_content(test::random_content(seed, 24, 0.02, 0.3, 0.4),
                              geometry::from_position_yaw({1, 2, 3}, 0.5), config);
}

}  // namespace

TEST(SubmapBytes, RoundTripAnswersTheSame) {
  const auto original = random_submap(1);
  const auto copy = Submap::from_bytes(original->to_bytes());
  EXPECT_EQ(copy->to_bytes(), original->to_bytes());
  std::mt19937 rng(1);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p = test::random_in(&rng, {-10, -10, -10}, {10, 10, 10});
    double a = 0.0;
    double b = 0.0;
    Vec3 ga = Vec3::Zero();
    Vec3 gb = Vec3::Zero();
    ASSERT_EQ(original->sample(p, &a, &ga), copy->sample(p, &b, &gb));
    ASSERT_EQ(a, b);
    ASSERT_EQ(ga, gb);
    ASSERT_EQ(original->state(p), copy->state(p));
  }
  EXPECT_EQ(original->occupied_points(), copy->occupied_points());
}

TEST(SubmapBytes, TruncatedIsRefused) {
  const std::string bytes = random_submap(1)->to_bytes();
  for (std::size_t size = 0; size < bytes.size(); size += 211) {
    EXPECT_THROW(Submap::from_bytes(bytes.substr(0, size)), std::invalid_argument);
    if (size >= 4) {
      EXPECT_THROW(Submap::from_bytes(test::resealed(bytes.substr(0, size))), std::invalid_argument);
    }
  }
}

TEST(SubmapBytes, FlippedBitsAreRefusedByTheChecksum) {
  const std::string bytes = random_submap(1)->to_bytes();
  std::mt19937 rng(9);
  for (int i = 0; i < 200; ++i) {
    std::string broken = bytes;
    broken[rng() % broken.size()] ^= static_cast<char>(1u << (rng() % 8));
    EXPECT_THROW(Submap::from_bytes(broken), std::invalid_argument);
  }
}

TEST(SubmapBytes, DamagedContentWithAMatchingChecksumIsRefusedOrHarmless) {
  const std::string bytes = random_submap(2)->to_bytes();
  std::mt19937 rng(10);
  int refused = 0;
  for (int i = 0; i < 1500; ++i) {
    std::string broken = bytes;
    const std::size_t reach = i % 2 == 0 ? broken.size() : 400;  // every second time in the header and first blocks
    for (unsigned k = 0; k < 1 + rng() % 4; ++k) broken[rng() % reach] = static_cast<char>(rng());
    try {
      const auto field = Submap::from_bytes(test::resealed(broken));
      for (int q = 0; q < 20; ++q) {
        double distance = 0.0;
        Vec3 gradient;
        field->sample(test::random_in(&rng, {-10, -10, -10}, {10, 10, 10}), &distance, &gradient);
        ASSERT_TRUE(std::isfinite(distance));
      }
      field->occupied_points();
    } catch (const std::invalid_argument&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 100);
}
