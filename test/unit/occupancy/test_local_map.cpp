// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "occupancy/log_odds.hpp"
#include "resealed.hpp"
#include "scan_maker.hpp"
#include "steps.hpp"
#include "voxnav/occupancy/local_map.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using occupancy::LocalMap;
using occupancy::LocalMapConfig;
using test::insert_from;

namespace {

const Vec3 kOrigin(0.2, 0.2, 0.2);

LocalMapConfig small_config() {
  LocalMapConfig config;
  config.window_size_m = {40, 40, 20};
  return config;
}

int scans_until(LocalMap* map, const Vec3& seen, const Vec3& at, VoxelState wanted, bool equal = true) {
  for (int n = 1; n < 50; ++n) {
    insert_from(map, kOrigin, {seen});
    if ((map->state(at) == wanted) == equal) return n;
  }
  return -1;
}

}  // namespace

TEST(LocalMap, HitAndMissCountsFollowTheReferenceTable) {
  const Vec3 near(5.0, 0.2, 0.2);
  const Vec3 behind(10.0, 0.2, 0.2);
  LocalMap map(small_config());
  EXPECT_EQ(scans_until(&map, near, near, VoxelState::kOccupied), 2);
  for (int i = 0; i < 10; ++i) insert_from(&map, kOrigin, {near});
  LocalMap copy = LocalMap::from_bytes(map.to_bytes());
  EXPECT_EQ(scans_until(&copy, behind, near, VoxelState::kOccupied, false), 6);
  EXPECT_EQ(scans_until(&map, behind, near, VoxelState::kFree), 11);
  for (int i = 0; i < 20; ++i) insert_from(&map, kOrigin, {behind});
  EXPECT_EQ(scans_until(&map, near, near, VoxelState::kOccupied), 4);

  LocalMap fresh(small_config());
  EXPECT_EQ(scans_until(&fresh, behind, near, VoxelState::kFree), 3);
}

TEST(LocalMap, AHitBesideSurfaceOutweighsEarlierMissesAndALoneOneDoesNot) {
  const Vec3 leaf(5.0, 0.2, 0.2), behind(10.0, 0.2, 0.2), branch(5.0, 0.6, 0.2);
  for (const bool is_alone : {false, true}) {
    LocalMap map(small_config());
    for (int i = 0; i < 20; ++i) insert_from(&map, kOrigin, {behind, is_alone ? Vec3(5.0, 1.4, 0.2) : branch});
    ASSERT_EQ(map.state(leaf), VoxelState::kFree);
    insert_from(&map, kOrigin, {leaf});
    EXPECT_EQ(map.state(leaf), is_alone ? VoxelState::kFree : VoxelState::kUnknown);
    EXPECT_EQ(scans_until(&map, leaf, leaf, VoxelState::kOccupied), is_alone ? 3 : 1);
  }
}

TEST(LocalMap, HitsWinWithinOneScan) {
  LocalMap map(small_config());
  const Vec3 near(5.0, 0.2, 0.2);
  for (int i = 0; i < 5; ++i) insert_from(&map, kOrigin, {near, Vec3(10.0, 0.2, 0.2), Vec3(8.0, 0.21, 0.2)});
  EXPECT_EQ(map.state(near), VoxelState::kOccupied);
  EXPECT_NEAR(*map.log_odds(near), occupancy::log_odds_of(0.971), 0.05);
}

TEST(LocalMap, ManyRaysThroughOneVoxelAreOneMiss) {
  LocalMap map(small_config());
  std::vector<Vec3> fan;
  fan.reserve(50);
  for (int i = 0; i < 50; ++i) fan.emplace_back(10.0, 0.2 + 0.01 * i, 0.2);
  const auto statistics = insert_from(&map, kOrigin, fan);
  EXPECT_NEAR(*map.log_odds(kOrigin), occupancy::log_odds_of(0.4), 0.01);
  EXPECT_EQ(statistics.cells_hit, 2u);
}

TEST(LocalMap, RaysBesideAThinPoleDoNotEraseIt) {
  LocalMap map(small_config());
  const Vec3 pole(8.05, 0.05, 0.2);
  for (int i = 0; i < 4; ++i) insert_from(&map, kOrigin, {pole});
  for (int i = 0; i < 100; ++i) insert_from(&map, kOrigin, {Vec3(12.0, 0.35, 0.2)});
  EXPECT_EQ(map.state(pole), VoxelState::kOccupied);
  for (int i = 0; i < 20; ++i) insert_from(&map, kOrigin, {kOrigin + 1.5 * (pole - kOrigin)});
  EXPECT_EQ(map.state(pole), VoxelState::kFree) << "seen straight through it is gone within 2 s at 10 Hz";
}

TEST(LocalMap, RaysOverASlopedGroundDoNotEraseIt) {
  LocalMap map(small_config());
  const Vec3 sensor(0.2, 0.2, 3.0);
  std::vector<Vec3> near_ground;
  std::vector<Vec3> farther_ground;
  for (const double x : test::steps(6.0, 14.0, 0.05)) near_ground.emplace_back(x, 0.2, 0.05);
  for (const double x : test::steps(14.0, 18.0, 0.5)) farther_ground.emplace_back(x, 0.2, 0.05);
  for (int i = 0; i < 4; ++i) insert_from(&map, sensor, near_ground);
  for (int i = 0; i < 100; ++i) insert_from(&map, sensor, farther_ground);
  for (const double x : test::steps(6.1, 14.0, 0.4)) {
    EXPECT_EQ(map.state(Vec3(x, 0.2, 0.05)), VoxelState::kOccupied) << x;
  }
}

TEST(LocalMap, BadPointsAreCountedAndChangeNothing) {
  LocalMap map(small_config());
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const float inf = std::numeric_limits<float>::infinity();
  const std::vector<float> points{nan, 0, 0, 7, 0, inf, 0, 7, 0, 0, 0, 7, 100, 0, 0, 7, 1, 0, 0, 7};
  const auto statistics = map.insert({points.data(), 5, 4}, test::at(0.2, 0.2, 0.2));
  EXPECT_EQ(statistics.rejected_not_finite, 2u);
  EXPECT_EQ(statistics.rejected_too_near, 1u);
  EXPECT_EQ(statistics.far, 1u);
  EXPECT_EQ(statistics.cells_hit, 1u);
  geometry::Pose bad = geometry::Pose::Identity();
  bad.translation().x() = nan;
  EXPECT_THROW(map.insert({points.data(), 5, 4}, bad), std::invalid_argument);
}

TEST(LocalMap, FarPointsClearUpToTheLongestRayOnly) {
  LocalMapConfig config = small_config();
  config.max_range_m = 10.0;
  LocalMap map(config);
  for (int i = 0; i < 3; ++i) insert_from(&map, kOrigin, {Vec3(60.2, 0.2, 0.2)});
  EXPECT_EQ(map.state(Vec3(9.8, 0.2, 0.2)), VoxelState::kFree);
  EXPECT_EQ(map.state(Vec3(10.8, 0.2, 0.2)), VoxelState::kUnknown);
  config.clear_beyond_range = false;
  LocalMap strict(config);
  for (int i = 0; i < 3; ++i) insert_from(&strict, kOrigin, {Vec3(60.2, 0.2, 0.2)});
  EXPECT_EQ(strict.state(Vec3(5.0, 0.2, 0.2)), VoxelState::kUnknown);
}

TEST(LocalMap, BeamsWithoutReturnNeverTouchAnOccupiedVoxel) {
  LocalMapConfig config = small_config();
  config.no_return_range_m = 8.0;
  LocalMap map(config);
  const Vec3 wall(5.0, 0.2, 0.2);
  for (int i = 0; i < 2; ++i) insert_from(&map, kOrigin, {wall});
  const std::vector<geometry::Vec3f> directions{{1.0f, 0.0f, 0.0f}};
  for (int i = 0; i < 30; ++i) map.insert({}, test::at(0.2, 0.2, 0.2), geometry::view_of(directions));
  EXPECT_EQ(map.state(wall), VoxelState::kOccupied);
  EXPECT_EQ(map.state(Vec3(7.0, 0.2, 0.2)), VoxelState::kFree);
  EXPECT_EQ(map.state(Vec3(9.0, 0.2, 0.2)), VoxelState::kUnknown);
}

TEST(LocalMap, MeanHitPointsLieOnTheSurface) {
  LocalMap map(small_config());
  std::vector<Vec3> wall;
  for (const double y : test::steps(-3.0, 3.0, 0.03)) {
    for (const double z : test::steps(-1.0, 1.0, 0.03)) wall.emplace_back(6.07, y, z);
  }
  for (int i = 0; i < 3; ++i) insert_from(&map, kOrigin, wall);
  const auto points = map.occupied_points();
  ASSERT_GT(points.size(), 100u);
  for (std::size_t i = 0; i < points.size(); i += 3) EXPECT_NEAR(points[i], 6.07, 1e-3);
}

TEST(LocalMap, FootprintBecomesFreeButNeverErasesAnObstacle) {
  LocalMap map(small_config());
  const Vec3 obstacle(0.6, 0.2, 0.2);
  for (int i = 0; i < 2; ++i) insert_from(&map, Vec3(-3.0, 0.2, 0.2), {obstacle});
  EXPECT_GT(map.mark_free(kOrigin, 1.0), 20u);
  EXPECT_EQ(map.state(obstacle), VoxelState::kOccupied);
  EXPECT_EQ(map.state(Vec3(0.2, 0.6, -0.2)), VoxelState::kFree);
  EXPECT_EQ(map.state(Vec3(0.2, 1.8, 0.2)), VoxelState::kUnknown);
}

TEST(LocalMap, ThresholdsChangeAtRunTime) {
  LocalMap map(small_config());
  const Vec3 p(5.0, 0.2, 0.2);
  insert_from(&map, kOrigin, {p});
  EXPECT_EQ(map.state(p), VoxelState::kUnknown);
  EXPECT_EQ(map.box_state({p, p}), VoxelState::kUnknown);
  map.set_thresholds(0.45, 0.6);
  EXPECT_EQ(map.state(p), VoxelState::kOccupied);
  EXPECT_EQ(map.box_state({p, p}), VoxelState::kOccupied);
  EXPECT_EQ(map.box_state({Vec3(2, 0.2, 0.2), Vec3(3, 0.2, 0.2)}), VoxelState::kFree);
  EXPECT_THROW(map.set_thresholds(0.5, 0.5), base::ConfigError);
}

TEST(LocalMap, FileRoundTripAndTruncation) {
  LocalMap map(small_config());
  for (unsigned i = 0; i < 4; ++i) insert_from(&map, kOrigin, test::random_points(i, 500, kOrigin, 12.0));
  const std::string bytes = map.to_bytes();
  LocalMap read = LocalMap::from_bytes(bytes);
  EXPECT_EQ(read.to_bytes(), bytes);
  EXPECT_EQ(read.content().to_bytes(), map.content().to_bytes());
  for (std::size_t size = 0; size < bytes.size(); size += bytes.size() / 13) {
    EXPECT_THROW(LocalMap::from_bytes(bytes.substr(0, size)), std::invalid_argument);
  }
  EXPECT_THROW(LocalMap::load("/nonexistent/map"), std::runtime_error);
}

TEST(LocalMap, AFileOfAnotherVersionIsNamedWithItsVersionAndTheOneThatIsRead) {
  const std::string path = ::testing::TempDir() + "voxnav_version_4.vxlm";
  const std::string bytes = test::as_version(4, LocalMap(small_config()).to_bytes());
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
  EXPECT_EQ(test::refusal_of([&] { LocalMap::load(path); }),
            path + ": local map has version 4 of its format; this program reads version 1 only");
}

TEST(LocalMap, ResultDoesNotDependOnThreads) {
  LocalMapConfig config = small_config();
  LocalMap one(config);
  config.num_threads = 3;
  LocalMap three(config);
  for (unsigned i = 0; i < 5; ++i) {
    const Vec3 origin(0.9 * i, 0.3, 0.1);
    insert_from(&one, origin, test::random_points(i % 2, 2000, Vec3(0, 0, 0), 12.0));
    insert_from(&three, origin, test::random_points(i % 2, 2000, Vec3(0, 0, 0), 12.0));
  }
  EXPECT_EQ(one.content().to_bytes(), three.content().to_bytes());
}
