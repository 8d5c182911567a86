// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "kernels/ray_walk.hpp"

using namespace voxnav;  // NOLINT: test
namespace ray_walk = kernels::ray_walk;

namespace {

constexpr int kSideA = 200, kSide = 70;  // lengths of the image in voxels, along axis a and along the two others
constexpr int kWordsA = kSideA / 32 + 1;

/// A bit image of all voxels with spare lines around it, as RayMarks has it.
struct Image {
  std::vector<std::uint32_t> words = std::vector<std::uint32_t>(std::size_t{kWordsA} * (kSide + 4) * (kSide + 4), 0u);
  ray_walk::Canvas canvas() {
    const std::int32_t step_c = kWordsA * (kSide + 4);
    return {words.data(), 2 * kWordsA + 2 * step_c, kWordsA, step_c, 20};
  }
};

struct Ends {
  std::vector<float> a, b, c;
};

/// Returns ends of rays on one side of the origin that are farther away along a than along b and c.
Ends random_ends(std::mt19937* rng, std::size_t n, bool is_ascending) {
  std::uniform_real_distribution<float> share(-1.0f, 1.0f), length(0.0f, 30.0f);
  Ends out;
  for (std::size_t i = 0; i < n; ++i) {
    const float along = i % 11 == 5 ? 0.0f : length(*rng);
    out.a.push_back(100.25f + (is_ascending ? along : -along));
    out.b.push_back(35.5f + (i % 7 == 3 ? 0.0f : along * share(*rng)));
    out.c.push_back(33.0f + (i % 5 == 2 ? 0.0f : along * share(*rng)));
  }
  return out;
}

}  // namespace

TEST(RayWalk, EqualsTheReference) {
  test::with_every_instruction_set([] {
    std::mt19937 rng(9);
    for (const std::size_t n : {1u, 7u, 8u, 9u, 64u, 500u}) {
      for (const bool is_ascending : {true, false}) {
        const Ends ends = random_ends(&rng, n, is_ascending);
        const ray_walk::Rays rays{ends.a.data(), ends.b.data(), ends.c.data(), n, 100.25f, 35.5f, 33.0f, is_ascending};
        Image image, expected;
        ray_walk::mark_rays(rays, image.canvas());
        ray_walk::reference::mark_rays(rays, expected.canvas());
        ASSERT_EQ(image.words, expected.words) << n << " rays";
      }
    }
  });
}
