// SPDX-License-Identifier: BSD-3-Clause
// Beams with width, their echoes, and rain.
#include <gtest/gtest.h>

#include "voxnav_simulation/lidar_model.hpp"
#include "world_test_tools.hpp"

namespace voxnav_simulation {
namespace {

/// No errors but those that a test adds.
LidarConfig perfect_lidar() {
  LidarConfig config;
  config.columns = 256;
  config.range_noise_m = config.dropout_ratio = config.signal_noise_ratio = 0.0;
  config.ghost_ratio = 0.0;
  config.body_capsules_m.clear();
  return config;
}

LidarScan scan_of(const LidarConfig& config, const Scene& scene, std::uint64_t index = 0) {
  const Pose T_W_L = voxnav::geometry::from_position_yaw({0.0, 0.0, 2.0}, 0.0);
  return LidarModel(config, 1).scan(scene, poses_between(T_W_L, T_W_L, config.columns), index);
}

std::size_t count_label(const LidarScan& scan, std::uint8_t label) {
  return static_cast<std::size_t>(std::count(scan.labels.begin(), scan.labels.end(), label));
}

std::size_t count_returns(const LidarScan& scan) { return scan.labels.size() - count_label(scan, kLabelNone); }

/// Thin poles on a plain, so that many footprints lie across an edge.
WorldConfig thin_poles() {
  WorldConfig config = empty_world();
  config.num_poles = 60;
  config.pole_radius_min_m = config.pole_radius_max_m = 0.01;
  return config;
}

TEST(BeamFootprint, AWideBeamMeetsThinPolesMoreOftenThanARay) {
  const Scene scene(World(thin_poles(), 1));
  LidarConfig config = perfect_lidar();
  const auto poles_seen = [&] { return count_label(scan_of(config, scene), static_cast<int>(SurfaceClass::kPole)); };
  const std::size_t by_rays = poles_seen();
  config.footprint_rays = 12;
  EXPECT_GT(poles_seen(), by_rays * 3 / 2);
}

TEST(BeamFootprint, OnOneSurfaceItMeasuresWhatARayMeasures) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  const LidarScan ray = scan_of(config, scene);
  config.footprint_rays = 12;
  const LidarScan beam = scan_of(config, scene);
  int compared = 0;
  for (std::size_t i = 0; i < ray.ranges_m.size(); ++i) {
    // Farther out the footprint is longer than an echo.
    if (ray.labels[i] == kLabelNone || ray.ranges_m[i] > 6.0F) continue;
    ASSERT_NE(beam.labels[i], kLabelNone);
    EXPECT_NEAR(beam.ranges_m[i], ray.ranges_m[i], 0.01 * ray.ranges_m[i]);
    ++compared;
  }
  EXPECT_GT(compared, 1000);
}

TEST(Echoes, MixOnlyWhatFollowsClosely) {
  WorldConfig world = thin_poles();
  world.num_walls = 8;
  const Scene scene(World(world, 2));
  LidarConfig config = perfect_lidar();
  config.columns = 1024;
  config.footprint_rays = 16;
  const auto mixed = [&](double separation_m) {
    config.echo_separation_m = separation_m;
    const LidarScan scan = scan_of(config, scene);
    int out = 0;
    for (std::size_t i = 0; i < scan.ranges_m.size(); ++i) {
      // Farther out a ray of the footprint passes more than this from the axis, on which its range is noted.
      if (scan.labels[i] == kLabelNone || scan.ranges_m[i] > 10.0F) continue;
      const auto& p = scan.points[i];
      out += scene.clearance(Vec3(p[0], p[1], p[2] + 2.0), 1.0) > 0.12 ? 1 : 0;
    }
    return out;
  };
  EXPECT_EQ(mixed(0.0), 0) << "echoes that are told apart lie on surfaces";
  EXPECT_GT(mixed(5.0), 10) << "echoes that are not lie between them";
}

TEST(Rain, IsSeenNearbyMoreTheMoreItRainsAndElsewhereInTheNextScan) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  EXPECT_EQ(count_label(scan_of(config, scene), kLabelRain), 0u);
  std::size_t before = 0;
  for (const double rate : {1.0, 5.0, 25.0}) {
    config.rain_mm_per_h = rate;
    const LidarScan scan = scan_of(config, scene);
    const std::size_t drops = count_label(scan, kLabelRain);
    EXPECT_GT(drops, before);
    before = drops;
    for (std::size_t i = 0; i < scan.labels.size(); ++i) {
      if (scan.labels[i] == kLabelRain) EXPECT_LT(scan.ranges_m[i], 10.0F);
    }
  }
  const LidarScan one = scan_of(config, scene, 0), other = scan_of(config, scene, 1);
  std::size_t both = 0;
  for (std::size_t i = 0; i < one.labels.size(); ++i) {
    both += one.labels[i] == kLabelRain && other.labels[i] == kLabelRain ? 1 : 0;
  }
  EXPECT_LT(both, before / 4);
}

TEST(Speckle, IsAsFrequentAsAskedAndEverywhere) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  config.speckle_ratio = 0.01;
  config.speckle_max_range_m = 2.0;  // nothing stands nearer
  const LidarScan scan = scan_of(config, scene);
  const double n = static_cast<double>(scan.labels.size());
  EXPECT_NEAR(static_cast<double>(count_label(scan, kLabelSpeckle)) / n, 0.01, 4 * std::sqrt(0.01 * 0.99 / n));
  config.speckle_max_range_m = 0.1;
  EXPECT_FALSE(config.problems().empty());
}

TEST(BeamFootprint, ScansDoNotDependOnThreads) {
  const Scene scene(World(small_world(), 3));
  LidarConfig config;
  config.columns = 128;
  config.footprint_rays = 7;
  config.rain_mm_per_h = 10.0;
  config.speckle_ratio = 0.001;
  const LidarScan one = scan_of(config, scene);
  config.num_threads = 3;
  const LidarScan three = scan_of(config, scene);
  EXPECT_GT(count_returns(one), 1000u);
  EXPECT_EQ(one.points, three.points);
  EXPECT_EQ(one.labels, three.labels);
}

}  // namespace
}  // namespace voxnav_simulation
