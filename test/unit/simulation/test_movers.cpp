// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <algorithm>

#include "voxnav_simulation/lidar_model.hpp"
#include "voxnav_simulation/random.hpp"
#include "world_test_tools.hpp"

namespace {

using namespace voxnav_simulation;  // NOLINT: test

constexpr StampNs kSecond_ns = 1'000'000'000;

Vec3 random_point(Rng* random, double reach) {
  const double x = random->uniform(-reach, reach), y = random->uniform(-reach, reach);
  return {x, y, random->uniform(-reach, reach)};
}

Mover cylinder() {
  Mover out;
  out.radius_m = 0.4;
  out.height_m = 1.3;
  return out;
}

/// Whether a point lies in the cylinder.
bool is_inside(const Mover& mover, const Vec3& bottom, const Vec3& p) {
  return (p - bottom).head<2>().norm() <= mover.radius_m && p.z() >= bottom.z() && p.z() <= bottom.z() + mover.height_m;
}

TEST(Movers, RaysAgreeWithBruteForce) {
  const Mover mover = cylinder();
  Rng random(1);
  int num_hits = 0;
  for (int k = 0; k < 3000; ++k) {
    const Vec3 bottom = random_point(&random, 1.0), origin = random_point(&random, 3.0);
    const Vec3 direction = (bottom + random_point(&random, 1.2) - origin).normalized();
    if (is_inside(mover, bottom, origin)) continue;
    constexpr double kStep_m = 0.002;
    double expected_m = 0;
    while (expected_m < 8.0 && !is_inside(mover, bottom, origin + expected_m * direction)) expected_m += kStep_m;
    const auto hit = cast_at_cylinder(mover, bottom, origin, direction);
    if (!hit) {
      double deep_m = 0;  // a miss may only graze it
      for (; expected_m < 8.0 && is_inside(mover, bottom, origin + expected_m * direction); expected_m += kStep_m)
        deep_m += kStep_m;
      EXPECT_LE(deep_m, 2 * kStep_m);
      continue;
    }
    ++num_hits;
    EXPECT_GT(hit->cos_incidence, 0.0);
    EXPECT_LE(hit->cos_incidence, 1.0 + 1e-9);
    EXPECT_LT(distance_to_cylinder(mover, bottom, origin + hit->range_m * direction), 1e-6);
    if (expected_m < 8.0) {
      EXPECT_NEAR(hit->range_m, expected_m, kStep_m);
    }
  }
  EXPECT_GT(num_hits, 100);
}

TEST(Movers, DistancesAgreeWithBruteForce) {
  const Mover mover = cylinder();
  std::vector<Vec3> surface;
  for (int i = 0; i < 120; ++i) {
    const double angle = 2.0 * M_PI * i / 120;
    const Vec3 side(std::cos(angle), std::sin(angle), 0);
    for (int j = 0; j <= 40; ++j) {
      surface.emplace_back(mover.radius_m * side + Vec3(0, 0, mover.height_m * j / 40));
      for (const double z : {0.0, mover.height_m}) surface.emplace_back(mover.radius_m * j / 40 * side + Vec3(0, 0, z));
    }
  }
  Rng random(2);
  for (int k = 0; k < 300; ++k) {
    const Vec3 p = random_point(&random, 2.0);
    double expected_m = 100;
    for (const Vec3& s : surface) expected_m = std::min(expected_m, (s - p).norm());
    if (is_inside(mover, Vec3::Zero(), p)) expected_m = 0;
    EXPECT_NEAR(distance_to_cylinder(mover, Vec3::Zero(), p), expected_m, 0.03);
  }
}

WorldConfig world_with_walkers() {
  WorldConfig config = empty_world();
  config.walker_waypoints = {0, 5, -2, 0, 5, 2, 1, 10, 0, 1, 14, 0, 1, 14, 3};
  config.flyer_waypoints = {0, -5, -3, 2, 0, -5, 3, 4};
  return config;
}

TEST(Movers, GoRoundAlongTheirWayPointsAtTheirSpeed) {
  const World world(world_with_walkers(), 1);
  ASSERT_EQ(world.movers().size(), 3u);
  const Mover& walker = world.movers()[0];
  EXPECT_EQ(walker.surface_class, SurfaceClass::kPerson);
  EXPECT_LT((walker.at(0) - Vec3(5, -2, 0)).norm(), 1e-9);
  EXPECT_LT((walker.at(kSecond_ns) - Vec3(5, -0.6, 0)).norm(), 1e-6);
  // The round of 8 m takes 8 / 1.4 s.
  const auto round_ns = static_cast<StampNs>(8.0 / 1.4 * kSecond_ns);
  EXPECT_LT((walker.at(round_ns / 2) - Vec3(5, 2, 0)).norm(), 1e-6);
  EXPECT_LT((walker.at(1000 * round_ns + kSecond_ns) - Vec3(5, -0.6, 0)).norm(), 1e-3);
  const Mover& flyer = world.movers()[2];
  EXPECT_EQ(flyer.surface_class, SurfaceClass::kFlyer);
  double low = 100, high = 0;
  for (const Mover& mover : world.movers()) {
    for (int i = 0; i < 500; ++i) {
      const Vec3 p = mover.at(i * kSecond_ns / 10), next = mover.at((i + 1) * kSecond_ns / 10);
      EXPECT_LE((next - p).norm(), 0.1 * mover.speed_mps + 1e-6);
      if (&mover == &flyer) low = std::min(low, p.z()), high = std::max(high, p.z());
    }
  }
  EXPECT_NEAR(low, 2.0, 0.1);
  EXPECT_NEAR(high, 4.0, 0.1);
}

TEST(Movers, FollowTheGround) {
  WorldConfig config = small_world();
  config.num_walkers = 5;
  const World world(config, 3);
  ASSERT_EQ(world.movers().size(), 5u);
  for (const Mover& mover : world.movers()) {
    for (int i = 0; i < 100; ++i) {
      const Vec3 p = mover.at(i * kSecond_ns / 2);
      EXPECT_NEAR(p.z(), world.ground_height(p.x(), p.y()).value_or(0.0), 0.15);
    }
  }
}

TEST(Movers, ThoseOfTheSeedCrossTheWayAndSpareStartAndGoal) {
  WorldConfig config = empty_world();
  config.min_corner_m = {-10, -30};
  config.size_m = {100, 60};
  config.goal_m = {80, 0};
  config.num_walkers = 6;
  config.num_flyers = 2;
  const World world(config, 5), again(config, 5), other(config, 6);
  ASSERT_EQ(world.movers().size(), 8u);
  for (std::size_t k = 0; k < 8; ++k) {
    EXPECT_EQ(world.movers()[k].at(kSecond_ns), again.movers()[k].at(kSecond_ns));
    EXPECT_NE(world.movers()[k].at(kSecond_ns), other.movers()[k].at(kSecond_ns));
    double left = 0, right = 0;
    for (int i = 0; i < 600; ++i) {
      const Vec3 p = world.movers()[k].at(i * kSecond_ns / 10);
      left = std::max(left, p.y()), right = std::min(right, p.y());
      EXPECT_GT(p.head<2>().norm(), 4.0);
      EXPECT_GT((p.head<2>() - Eigen::Vector2d(80, 0)).norm(), 4.0);
    }
    EXPECT_GT(left, 3.0);
    EXPECT_LT(right, -3.0);
  }
}

TEST(Movers, AreSeenByRaysAndCountForClearanceAtTheirTime) {
  const Scene scene(World(world_with_walkers(), 1));
  const Vec3f origin(0, -2, 1), ahead(1, 0, 0);
  Hit hit;
  scene.cast(origin, &ahead, 1, 100.0F, &hit);
  EXPECT_FALSE(hit.is_hit()) << "without a time there are no persons";
  scene.cast(origin, &ahead, 1, 100.0F, &hit, 0);
  EXPECT_NEAR(hit.range_m, 4.75, 1e-5);
  EXPECT_NEAR(hit.cos_incidence, 1.0, 1e-5);
  EXPECT_EQ(hit.surface_class, SurfaceClass::kPerson);
  scene.cast(origin, &ahead, 1, 4.0F, &hit, 0);
  EXPECT_FALSE(hit.is_hit()) << "out of range";
  scene.cast(origin, &ahead, 1, 100.0F, &hit, kSecond_ns);
  EXPECT_FALSE(hit.is_hit()) << "the person has walked on";
  const Vec3 beside(4, -2, 1);
  EXPECT_NEAR(scene.clearance(beside, 5.0, 0), 0.75, 1e-6);
  EXPECT_NEAR(scene.clearance(beside, 5.0), 1.0, 1e-6);
  const auto nearest = scene.nearest(beside, 5.0, 0);
  ASSERT_TRUE(nearest.has_value());
  EXPECT_EQ(nearest->surface_class, SurfaceClass::kPerson);
  EXPECT_EQ(scene.clearance({5, -2, 1}, 5.0, 0), 0.0) << "inside";
}

TEST(Movers, ATurnOfTheLidarShowsThemWhereTheyAre) {
  const Scene scene(World(world_with_walkers(), 1));
  LidarConfig config;
  config.columns = 1024;
  config.range_noise_m = config.dropout_ratio = config.min_signal = config.ghost_ratio = 0.0;
  config.body_capsules_m.clear();
  const Pose T_W_L = voxnav::geometry::from_position_yaw({0, 0, 1}, 0);
  const LidarModel lidar(config, 1);
  for (const std::uint64_t index : {0, 5, 12}) {
    const LidarScan scan = lidar.scan(scene, poses_between(T_W_L, T_W_L, config.columns), index);
    int count = 0;
    for (int row = 0; row < scan.rows; ++row) {
      for (int column = 0; column < scan.columns; ++column) {
        const std::size_t i = scan.index(row, column);
        if (scan.labels[i] != static_cast<int>(SurfaceClass::kPerson)) continue;
        const StampNs at_ns = static_cast<StampNs>(index) * lidar.sweep_ns() + scan.column_times_ns[column];
        const Vec3 p = T_W_L * Vec3(scan.points[i][0], scan.points[i][1], scan.points[i][2]);
        EXPECT_LT(scene.clearance(p, 1.0, at_ns), 1e-3);
        ++count;
      }
    }
    EXPECT_GT(count, 100);
  }
}

TEST(Movers, WayPointsThatMakeNoSenseAreNamed) {
  const auto problems = [](const std::vector<double>& walkers, const std::vector<double>& flyers) {
    WorldConfig config = empty_world();
    config.walker_waypoints = walkers;
    config.flyer_waypoints = flyers;
    return voxnav::base::problems_of(config).size();
  };
  EXPECT_EQ(problems({}, {}), 0u);
  EXPECT_EQ(problems({0, 1, 1}, {0, 1, 1, 2}), 0u);
  EXPECT_EQ(problems({0, 1}, {}), 1u);
  EXPECT_EQ(problems({1, 1, 1}, {}), 1u) << "person 0 has no way points";
  EXPECT_EQ(problems({0, 1, 500}, {}), 1u);
  EXPECT_EQ(problems({0, 1, 500}, {0, 1, 1, -1}), 2u);
  EXPECT_EQ(problems({0, 1, std::nan("")}, {}), 1u);
  EXPECT_EQ(problems({0.5, 1, 1}, {}), 1u);
}

}  // namespace
