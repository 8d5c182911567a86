// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <numeric>

#include "voxnav_simulation/lidar_model.hpp"
#include "world_test_tools.hpp"

namespace voxnav_simulation {
namespace {

constexpr double kDegree = M_PI / 180.0;

/// Returns a sensor without errors, to which each test adds the error that it checks.
LidarConfig perfect_lidar() {
  LidarConfig config;
  config.columns = 256;
  config.range_noise_m = config.dropout_ratio = config.signal_noise_ratio = 0.0;
  config.min_signal = config.ghost_ratio = 0.0;
  config.body_capsules_m.clear();
  return config;
}

Pose at_height(double z) { return voxnav::geometry::from_position_yaw({0.0, 0.0, z}, 0.0); }

LidarScan scan_from(const LidarConfig& config, const Scene& scene, const Pose& T_W_L, std::uint64_t index = 0) {
  return LidarModel(config, 1).scan(scene, poses_between(T_W_L, T_W_L, config.columns), index);
}

Vec3 point(const LidarScan& scan, std::size_t i) { return {scan.points[i][0], scan.points[i][1], scan.points[i][2]}; }

std::size_t count_label(const LidarScan& scan, std::uint8_t label) {
  return static_cast<std::size_t>(std::count(scan.labels.begin(), scan.labels.end(), label));
}

TEST(LidarConfig, KnowsTheUsualSensors) {
  LidarConfig config;
  EXPECT_EQ(config.elevations_rad().size(), 128u);
  EXPECT_NEAR(config.elevations_rad().front(), 45 * kDegree, 1e-9);
  EXPECT_NEAR(config.elevations_rad().back(), -45 * kDegree, 1e-9);
  config.model = BeamModel::kOs1With16;
  EXPECT_EQ(config.elevations_rad().size(), 16u);
  config.model = BeamModel::kCustom;
  EXPECT_EQ(config.problems().size(), 1u);
  config.beam_elevations_rad = {0.1, -0.1};
  EXPECT_TRUE(config.problems().empty());
  EXPECT_EQ(LidarModel(config, 1).rows(), 2);
}

TEST(LidarModel, PerfectReturnsLieOnTheirSurfaceInTheOrderOfAnImage) {
  const Scene scene(World(empty_world(), 1));
  const LidarScan scan = scan_from(perfect_lidar(), scene, at_height(2.0));
  ASSERT_EQ(scan.rows, 128);
  ASSERT_EQ(scan.columns, 256);
  for (int row = 0; row < scan.rows; ++row) {
    for (int column = 0; column < scan.columns; ++column) {
      const std::size_t i = scan.index(row, column);
      const double elevation = (45.0 - 90.0 * row / 127) * kDegree;
      const bool is_seen = elevation < 0 && 2.0 / std::sin(-elevation) < 100.0;
      ASSERT_EQ(scan.labels[i] == static_cast<int>(SurfaceClass::kTerrain), is_seen) << row << " " << column;
      if (!is_seen) {
        EXPECT_EQ(scan.points[i], (std::array<float, 4>{0, 0, 0, 0}));
        EXPECT_EQ(scan.ranges_m[i], 0.0F);
        continue;
      }
      EXPECT_NEAR(scan.points[i][2], -2.0, 2e-3);
      EXPECT_NEAR(point(scan, i).norm(), scan.ranges_m[i], 1e-3);
      // Column 0 looks backwards, and the sensor turns clockwise as seen from above.
      const double azimuth = M_PI - 2.0 * M_PI * column / 256;
      EXPECT_NEAR(voxnav::geometry::wrap_angle(std::atan2(scan.points[i][1], scan.points[i][0]) - azimuth), 0.0, 1e-4);
    }
  }
}

TEST(LidarModel, RangeNoiseHasTheConfiguredDeviation) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  const LidarScan truth = scan_from(config, scene, at_height(2.0));
  config.range_noise_m = 0.03;
  const LidarScan noisy = scan_from(config, scene, at_height(2.0));
  double sum = 0, squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < truth.labels.size(); ++i) {
    if (truth.labels[i] == kLabelNone || truth.ranges_m[i] > 90.0F) continue;
    const double error = noisy.ranges_m[i] - truth.ranges_m[i];
    sum += error;
    squares += error * error;
    ++count;
  }
  ASSERT_GT(count, 10000);
  EXPECT_NEAR(sum / count, 0.0, 4 * 0.03 / std::sqrt(count));
  EXPECT_NEAR(std::sqrt(squares / count), 0.03, 0.001);
}

TEST(LidarModel, LosesTheConfiguredShareOfReturns) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  const double all = static_cast<double>(count_label(scan_from(config, scene, at_height(2.0)), 0));
  config.dropout_ratio = 0.2;
  const double kept = static_cast<double>(count_label(scan_from(config, scene, at_height(2.0)), 0));
  EXPECT_NEAR(kept / all, 0.8, 4 * std::sqrt(0.2 * 0.8 / all));
}

TEST(LidarModel, GhostsAreNearWeakAndAsFrequentAsConfigured) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  config.ghost_ratio = 0.05;
  config.sun_half_angle_rad = 3.1416;
  const LidarScan scan = scan_from(config, scene, at_height(5.0));  // all surfaces are farther away than ghosts
  EXPECT_NEAR(static_cast<double>(count_label(scan, kLabelGhost)) / scan.labels.size(), 0.05,
              4 * std::sqrt(0.05 * 0.95 / scan.labels.size()));
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (scan.labels[i] != kLabelGhost) continue;
    EXPECT_GE(scan.ranges_m[i], config.min_range_m);
    EXPECT_LE(scan.ranges_m[i], config.ghost_max_range_m);
    EXPECT_LE(scan.points[i][3], config.ghost_intensity_max);
  }
}

TEST(LidarModel, GhostsComeFromTheSun) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  config.ghost_ratio = 1.0;
  config.sun_half_angle_rad = 0.3;
  Pose T_W_L = at_height(5.0);
  T_W_L.linear() = Eigen::AngleAxisd(2.0, Vec3::UnitZ()).toRotationMatrix();
  const LidarScan scan = scan_from(config, scene, T_W_L);
  const Vec3 sun(std::cos(0.6) * std::cos(0.8), std::cos(0.6) * std::sin(0.8), std::sin(0.6));
  EXPECT_GT(count_label(scan, kLabelGhost), 100u);
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (scan.labels[i] == kLabelNone) continue;
    const double angle = std::acos((T_W_L.linear() * point(scan, i)).normalized().dot(sun));
    EXPECT_EQ(scan.labels[i] == kLabelGhost, angle < 0.3) << angle;
  }
}

TEST(LidarModel, SignalFallsWithRangeAndAngleUntilNothingIsSeen) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  const int down = 127;
  const LidarScan low = scan_from(config, scene, at_height(10.0)), high = scan_from(config, scene, at_height(20.0));
  EXPECT_NEAR(low.points[low.index(down, 0)][3] / high.points[high.index(down, 0)][3], 4.0, 0.6);
  EXPECT_GT(low.points[low.index(127, 0)][3], low.points[low.index(100, 0)][3]);
  const float albedo_low = low.reflectivity[low.index(down, 0)], albedo_high = high.reflectivity[high.index(down, 0)];
  EXPECT_NEAR(albedo_low / albedo_high, 1.0, 0.15) << "reflectivity should not depend on range";
  config.min_signal = 1000.0;
  EXPECT_EQ(count_label(scan_from(config, scene, at_height(20.0)), kLabelNone), low.labels.size());
}

TEST(LidarModel, SeesItsOwnBodyWhereItIs) {
  const Scene scene(World(empty_world(), 1));
  LidarConfig config = perfect_lidar();
  config.mount_position_m = {0.0, 0.0, 0.2};
  config.mount_rpy_rad = {0.0, 0.0, M_PI / 2};
  config.body_capsules_m = {1.0, 0.0, 0.2, 1.0, 0.0, 0.2, 0.1};  // a ball ahead of the body
  const LidarScan scan = scan_from(config, scene, at_height(30.0));
  EXPECT_GT(count_label(scan, kLabelOwnBody), 10u);
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (scan.labels[i] != kLabelOwnBody) continue;
    EXPECT_NEAR((config.T_B_L() * point(scan, i) - Vec3(1.0, 0.0, 0.2)).norm(), 0.1, 1e-4);
    EXPECT_LT(scan.ranges_m[i], 1.0F) << "the far side of the ball";
  }
}

TEST(LidarModel, DefaultBodyIsSeenWithinArmsReachOnly) {
  const Scene scene(World(empty_world(), 1));
  const LidarScan scan = scan_from(LidarConfig(), scene, at_height(3.0));
  EXPECT_GT(count_label(scan, kLabelOwnBody), 100u);
  for (std::size_t i = 0; i < scan.labels.size(); ++i) {
    if (scan.labels[i] != kLabelOwnBody) continue;
    EXPECT_LT(scan.ranges_m[i], 0.6F);
  }
}

TEST(LidarModel, IsDeterministicForAnyNumberOfThreads) {
  const Scene scene(World(small_world(), 4));
  LidarConfig config;
  config.columns = 128;
  const LidarScan once = scan_from(config, scene, at_height(2.0), 17);
  const LidarScan again = scan_from(config, scene, at_height(2.0), 17),
                  later = scan_from(config, scene, at_height(2.0), 18);
  config.num_threads = 3;
  const LidarScan threaded = scan_from(config, scene, at_height(2.0), 17);
  EXPECT_EQ(once.points, again.points);
  EXPECT_EQ(once.points, threaded.points);
  EXPECT_EQ(once.labels, threaded.labels);
  EXPECT_NE(once.points, later.points);
}

TEST(LidarModel, ReturnsOfAForestLieOnItsMesh) {
  const Scene scene(World(small_world(), 4));
  LidarConfig config = perfect_lidar();
  const Pose T_W_L = voxnav::geometry::from_position_yaw({1.0, 0.5, 2.0}, 0.7);
  const LidarScan scan = scan_from(config, scene, T_W_L);
  std::vector<int> seen(kNumSurfaceClasses, 0);
  for (std::size_t i = 0; i < scan.labels.size(); i += 7) {
    if (scan.labels[i] == kLabelNone) continue;
    EXPECT_LT(scene.clearance(T_W_L * point(scan, i), 1.0), 1e-3);
    ++seen[scan.labels[i]];
  }
  for (const SurfaceClass c : {SurfaceClass::kTerrain, SurfaceClass::kTrunk, SurfaceClass::kFoliage}) {
    EXPECT_GT(seen[static_cast<int>(c)], 10) << name_of(c);
  }
}

/// Returns the root mean square height of all returns over level ground if each column has the given pose.
double flatness(const LidarScan& scan, const std::vector<Pose>& T_W_L) {
  double squares = 0;
  int count = 0;
  for (int row = 0; row < scan.rows; ++row) {
    for (int column = 0; column < scan.columns; ++column) {
      const std::size_t i = scan.index(row, column);
      if (scan.labels[i] == kLabelNone) continue;
      squares += std::pow((T_W_L[column] * point(scan, i)).z(), 2);
      ++count;
    }
  }
  return std::sqrt(squares / count);
}

TEST(LidarModel, MotionWithinATurnDistortsTheScanUntilItIsDeskewed) {
  const Scene scene(World(empty_world(), 1));
  const LidarConfig config = perfect_lidar();
  Pose end = voxnav::geometry::from_position_yaw({0.5, 0.1, 4.3}, 0.2);
  end.linear() = end.linear() * Eigen::AngleAxisd(0.15, Vec3::UnitY()).toRotationMatrix();
  const auto poses = poses_between(at_height(4.0), end, config.columns);
  const LidarScan scan = LidarModel(config, 1).scan(scene, poses, 0);
  EXPECT_LT(flatness(scan, poses), 2e-3);
  EXPECT_GT(flatness(scan, std::vector<Pose>(poses.size(), poses.front())), 0.3);
  EXPECT_THROW(LidarModel(config, 1).scan(scene, {}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace voxnav_simulation
