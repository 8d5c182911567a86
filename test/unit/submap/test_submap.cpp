// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "voxnav/submap/submap.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Pose;
using geometry::Vec3;
using submap::Submap;
using submap::SubmapConfig;

namespace {

constexpr double kVoxel = 0.4;

std::shared_ptr<Submap> make(const occupancy::MapContent& content, const Pose& T_S_G = Pose::Identity(),
                             const SubmapConfig& config = {}) {
  return Submap::from_content(content, T_S_G, config);
}

double distance_at(const Submap& field, const Vec3& p, Vec3* gradient = nullptr) {
  double distance = std::nan("");
  field.sample(p, &distance, gradient);
  return distance;
}

double plane(const Vec3& p) { return p.z() - 0.21 * p.x() + 0.1 * p.y() - 0.13; }
double plane_sdf(const Vec3& p) { return plane(p) / std::sqrt(1.0 + 0.21 * 0.21 + 0.01); }

}  // namespace

TEST(Submap, PlaneDistancesAreTrueOnBothSidesOfTheSurface) {
  const auto field = make(test::content_from_sdf(plane_sdf, {-20, -20, -20}, {20, 20, 20}, kVoxel));
  std::mt19937 rng(1);
  int checked = 0;
  double sum_squared = 0.0;
  for (int i = 0; i < 20000; ++i) {
    const Vec3 p = test::random_in(&rng, {-6, -6, -3}, {6, 6, 3});
    const double distance = distance_at(*field, p);
    if (std::isnan(distance)) {
      EXPECT_LT(plane_sdf(p), 0.5 * kVoxel);
      continue;
    }
    ++checked;
    // Surface points are a voxel apart, so the distance to the nearest one is a little longer than to the plane.
    EXPECT_NEAR(distance, plane_sdf(p), 0.5 * kVoxel);
    sum_squared += std::pow(distance - plane_sdf(p), 2);
  }
  EXPECT_GT(checked, 5000);
  EXPECT_LT(std::sqrt(sum_squared / checked), 0.1 * kVoxel);
}

TEST(Submap, ZeroLevelRunsThroughTheMeasuredPoints) {
  const auto field = make(test::content_from_sdf(plane_sdf, {-20, -20, -20}, {20, 20, 20}, kVoxel));
  ASSERT_GT(field->surface_points().size(), 500u);
  double sum = 0.0;
  for (const auto& point : field->surface_points()) {
    const double distance = distance_at(*field, point.position.cast<double>());
    ASSERT_FALSE(std::isnan(distance));
    EXPECT_LT(std::abs(distance), 0.35 * kVoxel);
    sum += distance;
    EXPECT_GT(point.weight, 0.f);
    EXPECT_NEAR(point.normal.norm(), 1.f, 1e-4);
  }
  EXPECT_LT(std::abs(sum / static_cast<double>(field->surface_points().size())), 0.06 * kVoxel);
}

TEST(Submap, NormalsPointToFreeSpace) {
  const auto field = make(test::content_from_sdf(plane_sdf, {-20, -20, -20}, {20, 20, 20}, kVoxel));
  const Vec3 truth = Vec3(-0.21, 0.1, 1.0).normalized();
  int close = 0;
  for (const auto& point : field->surface_points()) close += point.normal.cast<double>().dot(truth) > 0.99;
  EXPECT_GT(close, 0.9 * static_cast<double>(field->surface_points().size()));
}

TEST(Submap, SolidsHaveNegativeInside) {
  test::ContentBuilder builder(kVoxel);
  for (int x = -10; x < 10; ++x) {
    for (int y = -10; y < 10; ++y) {
      for (int z = -10; z < 10; ++z) {
        const bool inside = std::max({std::abs(2 * x + 1), std::abs(2 * y + 1), std::abs(2 * z + 1)}) < 10;
        inside ? builder.set_occupied({x, y, z}) : builder.set_free({x, y, z});
      }
    }
  }
  const auto field = make(builder.build());
  for (int x = -5; x < 5; ++x) {
    const Vec3 center = geometry::center_of({x, 0, 0}, kVoxel);
    const double to_face = 5 * kVoxel - std::abs(center.x());
    EXPECT_NEAR(distance_at(*field, center), -std::min(to_face, 3.0 * kVoxel), 0.02 * kVoxel);
  }
}

TEST(Submap, EveryOccupiedVoxelIsASurface) {
  // The scene has a pole of one voxel, a wire and single voxels in free space, and a pole beside unknown space.
  test::ContentBuilder builder(kVoxel);
  std::vector<geometry::Index3> thin;
  thin.reserve(45);
  for (int z = 0; z < 20; ++z) thin.push_back({3, 3, z});
  for (int x = 0; x < 20; ++x) thin.push_back({x, 12, 10});
  for (int i = 0; i < 5; ++i) thin.push_back({16, 4 * i, 17});
  for (int x = 0; x < 20; ++x) {
    for (int y = 0; y < 20; ++y) {
      for (int z = 0; z < 20; ++z) {
        if (x != 17) builder.set_free({x, y, z});
      }
    }
  }
  std::mt19937 rng(5);
  for (const auto& voxel : thin)
    builder.set_occupied(voxel, test::random_in(&rng, Vec3::Constant(-0.5), Vec3::Constant(0.5)));
  const auto content = builder.build();
  const auto field = make(content);
  ASSERT_EQ(field->occupied_points().size(), content.num_occupied());
  for (const auto& voxel : thin) {
    EXPECT_LE(distance_at(*field, geometry::center_of(voxel, kVoxel)), 0.0);
    EXPECT_EQ(field->state(geometry::center_of(voxel, kVoxel)), VoxelState::kOccupied);
  }
}

TEST(Submap, GradientIsThatOfTheDistance) {
  const auto field = make(test::random_content(7, 32, 0.02, 0.05, kVoxel));
  std::mt19937 rng(2);
  constexpr double h = 1e-5;
  int checked = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3 p = test::random_in(&rng, {-6, -1, -8}, {6, 11, 4});
    Vec3 gradient;
    if (std::isnan(distance_at(*field, p, &gradient))) continue;
    Vec3 numeric;
    double jump = 0.0;
    for (int k = 0; k < 3; ++k) {
      const double ahead = distance_at(*field, p + Vec3::Unit(k) * h);
      const double behind = distance_at(*field, p - Vec3::Unit(k) * h);
      numeric[k] = (ahead - behind) / (2.0 * h);
      jump = std::max(jump, std::abs(ahead + behind - 2.0 * distance_at(*field, p)));
    }
    if (!numeric.allFinite() || jump > 1e-7) continue;  // the differences cross an edge between cells
    ++checked;
    ASSERT_LT((numeric - gradient).norm(), 1e-3) << p.transpose();
  }
  EXPECT_GT(checked, 1500);
}

TEST(Submap, UnknownAndNotFiniteAreUnobserved) {
  const auto field = make(test::content_from_sdf(plane_sdf, {-20, -20, -20}, {20, 20, 20}, kVoxel));
  EXPECT_TRUE(std::isnan(distance_at(*field, {0, 0, -5})));
  EXPECT_TRUE(std::isnan(distance_at(*field, {100, 0, 0})));
  EXPECT_TRUE(std::isnan(distance_at(*field, {std::nan(""), 0, 0})));
  EXPECT_TRUE(std::isnan(distance_at(*field, {1e300, 0, 0})));
  EXPECT_EQ(field->state({100, 0, 0}), VoxelState::kUnknown);
}

TEST(Submap, EmptyContentIsUnobservedEverywhere) {
  occupancy::MapContent empty;
  empty.resolution_m = kVoxel;
  const auto field = make(empty);
  EXPECT_TRUE(std::isnan(distance_at(*field, {0, 0, 0})));
  EXPECT_TRUE(field->surface_points().empty());
}

TEST(Submap, ContentBeyondTheVoxelIndicesIsRefused) {
  auto content = test::random_content(1, 8, 0.1, 0.1, kVoxel);
  content.blocks.back().index.x = -1174405121;  // the indices of its voxels overflow 32 bits
  EXPECT_THROW(make(content), std::invalid_argument);
  for (const double resolution_m : {0.0, -0.4, 1e-300, 1e300, std::nan("")}) {
    content = test::random_content(1, 8, 0.1, 0.1, kVoxel);
    content.resolution_m = resolution_m;
    EXPECT_THROW(make(content), std::invalid_argument) << resolution_m;
  }
}

TEST(Submap, FrameChangeMovesTheFieldRigidly) {
  const auto content = test::random_content(3, 24, 0.03, 0.1, kVoxel);
  const Pose T_S_G = geometry::from_position_yaw({3.0, -200.0, 7.0}, 0.7);
  const auto in_G = make(content);
  const auto in_S = make(content, T_S_G);
  std::mt19937 rng(2);
  for (int i = 0; i < 1000; ++i) {
    const Vec3 p_G = test::random_in(&rng, {-5, -1, -8}, {5, 8, 1});
    Vec3 gradient_G = Vec3::Zero();
    Vec3 gradient_S = Vec3::Zero();
    const double a = distance_at(*in_G, p_G, &gradient_G);
    const double b = distance_at(*in_S, T_S_G * p_G, &gradient_S);
    ASSERT_EQ(std::isnan(a), std::isnan(b));
    if (std::isnan(a)) continue;
    ASSERT_NEAR(a, b, 1e-9);
    ASSERT_LT((T_S_G.linear() * gradient_G - gradient_S).norm(), 1e-6);
  }
}

TEST(Submap, SurfacePointsAreBoundedAndSpread) {
  SubmapConfig config;
  config.max_surface_points = 100;
  const auto content = test::content_from_sdf(plane_sdf, {-20, -20, -20}, {20, 20, 20}, kVoxel);
  const auto field = make(content, Pose::Identity(), config);
  ASSERT_EQ(field->surface_points().size(), 100u);
  EXPECT_LT(field->surface_bounds().min.x(), -6.0);
  EXPECT_GT(field->surface_bounds().max.x(), 6.0);
}

TEST(Submap, BadConfigurationIsRefused) {
  SubmapConfig config;
  config.band_voxels = 1.0;
  EXPECT_THROW(make(test::random_content(1, 4, 0.1, 0.1, kVoxel), Pose::Identity(), config), base::ConfigError);
}

TEST(Submap, ASingleVoxelInUnknownSpaceIsNotDeepInside) {
  test::ContentBuilder builder(kVoxel);
  builder.set_occupied({5, 5, 5});
  builder.set_free({8, 5, 5});
  const auto field = make(builder.build());
  EXPECT_NEAR(distance_at(*field, geometry::center_of({5, 5, 5}, kVoxel)), -0.5 * kVoxel, 0.01);
}
