// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <limits>
#include <memory>
#include <random>
#include <vector>

#include "instruction_sets.hpp"
#include "kernels/blend_moments.hpp"
#include "kernels/seen_octants.hpp"

using namespace voxnav;  // NOLINT: test
using geometry::Vec3f;
using kernels::PointBatch;

namespace {

constexpr float kFarthest_m = 30.0f;
constexpr float kResolution_m = 0.4f;
const kernels::DrawnRanges kRanges{0.25f, kFarthest_m* kFarthest_m,
                                   static_cast<float>(kernels::kMaxBeamRange - 1) / kFarthest_m};

std::vector<Vec3f> random_ends(unsigned seed, std::size_t n) {
  std::mt19937 rng(seed);
  std::normal_distribution<float> direction;
  std::uniform_real_distribution<float> range(0.1f, 35.0f);
  std::vector<Vec3f> out;
  while (out.size() < n) {
    out.emplace_back(Vec3f(direction(rng), direction(rng), direction(rng)).normalized() * range(rng));
  }
  return out;
}

/// The fine and the coarse image of some beams, of which the first in a pixel is kept.
struct Images {
  std::vector<kernels::BeamPixel> fine, coarse;
  explicit Images(const std::vector<Vec3f>& ends)
      : fine(6 * kernels::kFineSide * kernels::kFineSide + kernels::lanes::kLanes),
        coarse(6 * kernels::kCoarseSide * kernels::kCoarseSide + kernels::lanes::kLanes),
        ends_(ends) {
    PointBatch batch;
    kernels::DrawnBatch drawn;
    for (std::size_t begin = 0; begin < ends.size(); begin += PointBatch::kSize) {
      const std::size_t count = batch.load(ends[begin].data(), ends.size() - begin, 3);
      kernels::reference::draw_beams(batch, kRanges, &drawn);
      for (std::size_t i = 0; i < count; ++i) {
        if (drawn.range[i] == 0) continue;
        const auto beam = (drawn.range[i] << kernels::kBeamBits) | static_cast<kernels::BeamPixel>(begin + i);
        auto& fine_pixel = fine[static_cast<std::size_t>(drawn.fine[i])];
        auto& coarse_pixel = coarse[static_cast<std::size_t>(drawn.coarse[i])];
        if (fine_pixel == 0) fine_pixel = beam;
        if (coarse_pixel == 0) coarse_pixel = beam;
      }
    }
  }
  kernels::BeamImages view() const { return {fine.data(), coarse.data(), ends_[0].data(), 3, kRanges.steps_per_m}; }

 private:
  const std::vector<Vec3f>& ends_;
};

kernels::SightRules make_rules() {
  kernels::SightRules rules;
  rules.to_window =
      Eigen::AngleAxisf(0.7f, Vec3f(0.2f, -0.1f, 1.0f).normalized()).toRotationMatrix() * (1.0f / kResolution_m);
  rules.to_frame_L = rules.to_window.transpose() * (kResolution_m * kResolution_m);
  rules.resolution_m = kResolution_m;
  rules.longest = kFarthest_m / kResolution_m;
  rules.behind = 1.5f;
  rules.sigmas = 2.0f;
  rules.spread = 0.05f;
  return rules;
}

/// Some voxels of a block and the moments of the hits in them.
struct Voxels {
  std::array<std::array<std::int16_t, 8>, kernels::lanes::kLanes> means{}, covariances{};
  kernels::AskedVoxels asked;

  Voxels(std::mt19937* rng, int size) {
    std::uniform_real_distribution<float> offset(-0.5f, 0.5f), spread(0.0f, 0.05f);
    asked.size = size;
    for (int i = 0; i < kernels::lanes::kLanes; ++i) {
      const auto lane = static_cast<std::size_t>(i);
      for (std::size_t k = 0; k < 3; ++k) {
        means[lane][k] = static_cast<std::int16_t>(offset(*rng) * 2.0f * kernels::kMeanUnits);
      }
      for (const std::size_t k : {0u, 3u, 5u}) {
        covariances[lane][k] = static_cast<std::int16_t>(spread(*rng) * kernels::kCovarianceUnits);
      }
      asked.offsets[i] = i < size ? static_cast<std::int32_t>((*rng)() % 4096) : asked.offsets[0];
      asked.means[i] = means[i < size ? lane : 0].data();
      asked.covariances[i] = covariances[i < size ? lane : 0].data();
    }
  }
};

}  // namespace

TEST(DrawBeams, EqualsTheReference) {
  test::with_every_instruction_set([] {
    const auto drawn = std::make_unique<kernels::DrawnBatch>(), expected = std::make_unique<kernels::DrawnBatch>();
    for (unsigned seed = 0; seed < 20; ++seed) {
      const std::vector<Vec3f> ends = random_ends(seed, PointBatch::kSize);
      PointBatch batch;
      batch.load(ends[0].data(), ends.size(), 3);
      batch.x[5] = batch.y[9] = std::numeric_limits<float>::quiet_NaN();
      batch.x[6] = batch.y[6] = batch.z[6] = 0.0f;
      batch.y[7] = batch.x[7];
      kernels::draw_beams(batch, kRanges, drawn.get());
      kernels::reference::draw_beams(batch, kRanges, expected.get());
      for (std::size_t i = 0; i < PointBatch::kSize; ++i) {
        ASSERT_EQ(drawn->range[i], expected->range[i]) << i;
        if (drawn->range[i] == 0) continue;  // beams with range 0 are not drawn, so their pixels do not matter
        ASSERT_EQ(drawn->fine[i], expected->fine[i]) << i;
        ASSERT_EQ(drawn->coarse[i], expected->coarse[i]) << i;
      }
    }
  });
}

TEST(SeenOctants, EqualTheReference) {
  const std::vector<Vec3f> ends = random_ends(1, 60000);
  const Images images(ends);
  const kernels::SightRules rules = make_rules();
  test::with_every_instruction_set([&] {
    std::mt19937 rng(2);
    std::uniform_real_distribution<float> place(-60.0f, 60.0f);
    int num_seen = 0, num_whole = 0;
    for (int trial = 0; trial < 1500; ++trial) {
      const float near = trial % 4 == 0 ? 0.1f : 1.0f;  // every fourth block contains or touches the sensor
      const Vec3f first_center(near * place(rng) - 8.0f, near * place(rng) - 8.0f, near * place(rng) - 8.0f);
      const Voxels voxels(&rng, 1 + trial % kernels::lanes::kLanes);
      alignas(32) std::int32_t octants[kernels::lanes::kLanes], expected[kernels::lanes::kLanes];
      kernels::seen_octants(images.view(), rules, first_center, voxels.asked, octants);
      kernels::reference::seen_octants(images.view(), rules, first_center, voxels.asked, expected);
      for (int i = 0; i < voxels.asked.size; ++i) {
        ASSERT_EQ(octants[i], expected[i]) << trial << " " << i;
        num_seen += octants[i] != 0 ? 1 : 0;
        num_whole += octants[i] == 0xFF ? 1 : 0;
      }
    }
    EXPECT_GT(num_seen, 100);
    EXPECT_GT(num_whole, 10);
  });
}
