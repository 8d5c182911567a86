// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "content_builder.hpp"
#include "voxnav/submap/projective_integrator.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Pose;
using geometry::Vec3;
using geometry::Vec3f;
using submap::ProjectiveConfig;
using submap::ProjectiveIntegrator;
using submap::RayRule;

namespace {

constexpr double kRadius = 4.0;
const Vec3 kCenter(0.3, -0.2, 8.1);

/// Returns the hits of rays over the full sphere of directions; rays without a hit within 40 m give no point.
std::vector<Vec3f> scan(const Pose& T_S_L, const test::Sdf& sdf) {
  std::vector<Vec3f> points;
  for (int row = -40; row <= 40; ++row) {
    for (int column = 0; column < 360; ++column) {
      const double elevation = row * 0.038;
      const double azimuth = column * M_PI / 180.0;
      const Vec3 u_L(std::cos(elevation) * std::cos(azimuth), std::cos(elevation) * std::sin(azimuth),
                     std::sin(elevation));
      const Vec3 u = T_S_L.linear() * u_L;
      double range = 0.0;
      double distance = 1.0;
      for (int i = 0; i < 200 && distance > 1e-4 && range < 40.0; ++i) {
        distance = sdf(T_S_L.translation() + range * u);
        range += distance;
      }
      if (distance < 1e-3) points.emplace_back((u_L * range).cast<float>());
    }
  }
  return points;
}

double sphere(const Vec3& p) { return (p - kCenter).norm() - kRadius; }
double wall(const Vec3& p) { return 6.13 - p.x(); }

class Rules : public ::testing::TestWithParam<RayRule> {};

ProjectiveIntegrator integrated(RayRule rule, const test::Sdf& sdf, const std::vector<Vec3>& origins) {
  ProjectiveConfig config;
  config.rule = rule;
  ProjectiveIntegrator integrator(config);
  for (const Vec3& origin : origins) {
    const Pose T_S_L = geometry::from_position_yaw(origin, 0.3);
    integrator.integrate(scan(T_S_L, sdf), T_S_L);
  }
  return integrator;
}

}  // namespace

TEST_P(Rules, WallDistancesAreProjectiveAndItsZeroLevelIsTrue) {
  auto integrator = integrated(GetParam(), wall, {{0, 0, 0}, {1, 1, 0.5}, {0, -1, -1}});
  float distance = 0.f;
  float weight = 0.f;
  // Perpendicular to the wall, the projective distance equals the true one.
  ASSERT_TRUE(integrator.voxel(geometry::index_of({5.6, 0.2, 0.2}, 0.4), &distance, &weight));
  EXPECT_NEAR(distance, wall(geometry::center_of(geometry::index_of({5.6, 0.2, 0.2}, 0.4), 0.4)), 0.06);
  const auto field = integrator.finish({});
  ASSERT_GT(field->surface_points().size(), 300u);
  double sum = 0.0;
  for (const auto& point : field->surface_points()) sum += std::abs(wall(point.position.cast<double>()));
  EXPECT_LT(sum / static_cast<double>(field->surface_points().size()), 0.1);
}

TEST_P(Rules, SphereSurfaceIsFoundAndSpaceInFrontIsFree) {
  const std::vector<Vec3> around = {{8, 0, 8}, {-8, 1, 8}, {0, 8, 9}, {1, -8, 7}, {0, 0, 0.5}, {0, 1, 16}};
  const auto field = integrated(GetParam(), sphere, around).finish({});
  double sum = 0.0;
  for (const auto& p : field->occupied_points()) {
    const double error = std::abs(sphere(p.cast<double>()));
    sum += error;
    EXPECT_LT(error, 0.8);
  }
  ASSERT_GT(field->occupied_points().size(), 800u);
  EXPECT_LT(sum / static_cast<double>(field->occupied_points().size()), 0.12);
  std::mt19937 rng(1);
  for (int i = 0; i < 5000; ++i) {
    const Vec3 p = test::random_in(&rng, {-8, -8, 0}, {8, 8, 16});
    if (sphere(p) < -0.6) {
      ASSERT_NE(field->state(p), VoxelState::kFree);
    }
  }
  EXPECT_EQ(field->state(Vec3(6, 0, 8)), VoxelState::kFree);
}

INSTANTIATE_TEST_SUITE_P(All, Rules, ::testing::Values(RayRule::kSimple, RayRule::kMerged, RayRule::kFast));

TEST(ProjectiveIntegrator, WithoutCarvingOnlyTheBandIsObserved) {
  ProjectiveConfig config;
  config.use_carving = false;
  ProjectiveIntegrator integrator(config);
  integrator.integrate(scan(Pose::Identity(), wall), Pose::Identity());
  float distance = 0.f;
  float weight = 0.f;
  EXPECT_FALSE(integrator.voxel(geometry::index_of({2.0, 0.2, 0.2}, 0.4), &distance, &weight));
  EXPECT_TRUE(integrator.voxel(geometry::index_of({5.8, 0.2, 0.2}, 0.4), &distance, &weight));
}

TEST(ProjectiveIntegrator, AntiGrazingKeepsAThinPole) {
  // A pole stands before a wall, and rays to the wall pass through the voxels of the pole.
  const test::Sdf pole_and_wall = [](const Vec3& p) {
    return std::min(wall(p), std::hypot(p.x() - 4.0, p.y() - 0.2) - 0.06);
  };
  std::size_t kept[2];
  for (const bool use : {false, true}) {
    ProjectiveConfig config;
    config.use_anti_grazing = use;
    ProjectiveIntegrator integrator(config);
    for (int i = 0; i < 5; ++i) {
      const Pose T_S_L = geometry::from_position_yaw({0.1 * i, 0.3 * i - 0.6, 0.05}, 0.01 * i);
      integrator.integrate(scan(T_S_L, pole_and_wall), T_S_L);
    }
    const auto field = integrator.finish({});
    kept[use] = 0;
    for (const auto& p : field->occupied_points()) kept[use] += std::hypot(p.x() - 4.f, p.y() - 0.2f) < 0.5f;
  }
  EXPECT_GT(kept[1], kept[0]);
  EXPECT_GT(kept[1], 15u);
}

TEST(ProjectiveIntegrator, PointsBeyondTheRangeOnlyClearSpace) {
  ProjectiveConfig config;
  config.max_range_m = 10.0;
  ProjectiveIntegrator integrator(config);
  integrator.integrate({Vec3f(50.f, 0.1f, 0.1f)}, Pose::Identity());
  float distance = 0.f;
  float weight = 0.f;
  ASSERT_TRUE(integrator.voxel(geometry::index_of({5.0, 0.0, 0.0}, 0.4), &distance, &weight));
  EXPECT_GT(distance, 0.f);
  const auto field = integrator.finish({});
  EXPECT_TRUE(field->occupied_points().empty());
}

TEST(ProjectiveIntegrator, BadPointsAreCountedAndChangeNothing) {
  ProjectiveIntegrator integrator(ProjectiveConfig{});
  const float nan = std::nanf("");
  const auto counts = integrator.integrate({{nan, 0, 0}, {0, 0, 0}, {INFINITY, 1, 1}, {0.1f, 0, 0}}, Pose::Identity());
  EXPECT_EQ(counts.dropped, 4u);
  EXPECT_EQ(counts.voxels, 0u);
  EXPECT_EQ(integrator.integrate({}, Pose::Identity()).rays, 0u);
  Pose broken = Pose::Identity();
  broken.translation().x() = std::nan("");
  EXPECT_THROW(integrator.integrate({}, broken), std::invalid_argument);
}

TEST(ProjectiveIntegrator, BlocksAreBounded) {
  ProjectiveConfig config;
  config.max_blocks = 2;
  ProjectiveIntegrator integrator(config);
  EXPECT_GT(integrator.integrate(scan(Pose::Identity(), wall), Pose::Identity()).refused, 0u);
}
