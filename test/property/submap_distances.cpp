// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "kernels/processor.hpp"
#include "submap/distance/derive_distances.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using submap::Submap;

namespace {

constexpr double kVoxel = 0.4;

struct Truth {
  std::vector<Vec3> points;   // the surface points
  std::vector<Vec3> corners;  // the lowest corner of each occupied voxel
};

Truth truth_of(const occupancy::MapContent& content) {
  Truth out;
  for (const auto& block : content.blocks) {
    for (const auto& leaf : block.occupied) {
      out.points.emplace_back(occupancy::surface_point(block.index, leaf, content.resolution_m).cast<double>());
      const auto voxel = geometry::voxel_at(block.index, leaf.offset);
      out.corners.emplace_back(Vec3(voxel.x, voxel.y, voxel.z) * content.resolution_m);
    }
  }
  return out;
}

double to_points(const Truth& truth, const Vec3& p) {
  double best = 1e9;
  for (const Vec3& q : truth.points) best = std::min(best, (p - q).norm());
  return best;
}

double to_cubes(const Truth& truth, const Vec3& p) {
  double best = 1e9;
  for (const Vec3& low : truth.corners) {
    best = std::min(best, (p - p.cwiseMax(low).cwiseMin(low + Vec3::Constant(kVoxel))).norm());
  }
  return best;
}

}  // namespace

class SubmapDistances : public ::testing::TestWithParam<double> {};

TEST_P(SubmapDistances, OfFreeVoxelCentersEqualBruteForce) {
  const auto content = test::random_content(11, 40, GetParam(), 0.1, kVoxel);
  const auto field = Submap::from_content(content, geometry::Pose::Identity(), {});
  const Truth truth = truth_of(content);
  const double quantum = 3.0 * kVoxel / 127.0;
  for (const auto& block : content.blocks) {
    for (int offset = 0; offset < geometry::kBlockVolume; offset += 7) {
      if (block.states.get(offset) != VoxelState::kFree) continue;
      const Vec3 center = geometry::center_of(geometry::voxel_at(block.index, offset), kVoxel);
      double distance = 0.0;
      ASSERT_TRUE(field->sample(center, &distance, nullptr));
      ASSERT_NEAR(distance, std::min(to_points(truth, center), 10.0), 0.51 * quantum);
    }
  }
}

TEST_P(SubmapDistances, CertifiedNeverExceedTheTruth) {
  const auto content = test::random_content(12, 40, GetParam(), 0.1, kVoxel);
  submap::SubmapConfig config;
  config.certified = true;
  const auto field = Submap::from_content(content, geometry::Pose::Identity(), config);
  const Truth truth = truth_of(content);
  std::mt19937 rng(4);
  int observed = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = test::random_in(&rng, {-8, -1.2, -8}, {8, 14.8, 8});
    double distance = 0.0;
    if (!field->sample(p, &distance, nullptr)) continue;
    ++observed;
    const double exact = to_cubes(truth, p);
    ASSERT_LE(distance, exact + 1e-9);
    if (exact > 0.0) {
      ASSERT_NEAR(distance, std::min(exact, 10.0), 1e-6);
    }
  }
  EXPECT_GT(observed, 1000);
}

TEST_P(SubmapDistances, EveryInstructionSetGivesTheSame) {
  const auto content = test::random_content(14, 40, GetParam(), 0.1, kVoxel);
  const auto derive = [&](bool wide) {
    kernels::use_wide(wide);
    const auto field = Submap::from_content(content, geometry::Pose::Identity(), {});
    std::vector<float> out;
    for (const auto& p : field->surface_points()) out.insert(out.end(), {p.normal.x(), p.normal.y(), p.normal.z()});
    for (const auto& block : content.blocks) {
      const auto distances = submap::derive_distances(*field->content(), block.index);
      std::array<float, 8> corners;
      for (int i = 0; i < geometry::kBlockVolume; ++i) {
        const bool is_known = distances && distances->corners((i & 15) - 1, (i >> 4 & 15) - 1, (i >> 8) - 1, &corners);
        out.push_back(is_known ? corners[0] : 99.0F);
      }
    }
    return out;
  };
  const auto plain = derive(false);
  EXPECT_EQ(derive(true), plain);
}

INSTANTIATE_TEST_SUITE_P(Densities, SubmapDistances, ::testing::Values(0.0, 0.0005, 0.01, 0.1));
