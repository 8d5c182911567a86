// SPDX-License-Identifier: BSD-3-Clause
// The local map is compared with brute force after random insertions and moves of its window.
#include <gtest/gtest.h>

#include <limits>

#include "occupancy/local_map_impl.hpp"
#include "occupancy/segment_distance.hpp"
#include "scan_maker.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Index3;
using geometry::Vec3;
using occupancy::LocalMap;
using occupancy::OctreeBlock;

namespace {

constexpr double kResolution = 0.4;

LocalMap flown_map(unsigned seed) {
  occupancy::LocalMapConfig config;
  config.window_size_m = {26, 26, 14};
  config.max_range_m = 12.0;
  LocalMap map(config);
  std::mt19937 rng(seed);
  Vec3 origin(0, 0, 1);
  for (int i = 0; i < 25; ++i) {
    test::insert_from(&map, origin, test::random_points(seed * 100 + static_cast<unsigned>(i) / 4, 400, origin, 8.0));
    origin += Vec3(static_cast<int>(rng() % 5) - 1, static_cast<int>(rng() % 3) - 1, static_cast<int>(rng() % 3) - 1);
    if (rng() % 8 == 0) map.mark_free(origin, 1.5);
  }
  return map;
}

int badness(VoxelState state) { return state == VoxelState::kOccupied ? 2 : state == VoxelState::kUnknown ? 1 : 0; }

VoxelState brute_state(const LocalMap& map, const Index3& voxel) {
  return map.state(geometry::center_of(voxel, kResolution));
}

template <class F>
void for_voxels(const Vec3& low, const Vec3& high, F f) {
  const Index3 a = geometry::index_of(low, kResolution);
  const Index3 b = geometry::index_of(high, kResolution);
  Index3 v;
  for (v.z = a.z; v.z <= b.z; ++v.z) {
    for (v.y = a.y; v.y <= b.y; ++v.y) {
      for (v.x = a.x; v.x <= b.x; ++v.x) f(v);
    }
  }
}

Vec3 random_near(const LocalMap& map, std::mt19937* rng, double reach) {
  const auto& n = map.impl().forest.window.num_blocks();
  const Index3 first = map.impl().forest.window.first_block();
  const Vec3 middle = (Vec3(first.x, first.y, first.z) + 0.5 * Vec3(n[0], n[1], n[2])) * 16 * kResolution;
  std::uniform_real_distribution<double> uniform(-reach, reach);
  const double x = uniform(*rng);
  const double y = uniform(*rng);
  return middle + Vec3(x, y, 0.4 * uniform(*rng));
}

}  // namespace

TEST(LocalMapProperty, InnerNodesEqualBruteForce) {
  for (unsigned seed = 1; seed <= 3; ++seed) {
    const LocalMap map = flown_map(seed);
    int blocks = 0;
    for (int slot = 0; slot < map.impl().forest.window.num_slots(); ++slot) {
      const OctreeBlock* block = map.impl().forest.window.at(slot);
      if (block == nullptr) continue;
      ++blocks;
      for (int level = 1; level <= OctreeBlock::kLevels; ++level) {
        const int side = 16 >> level;
        const int num_nodes = side * side * side;
        std::vector<int> highest(static_cast<std::size_t>(num_nodes), 0);
        std::vector<int> flags(static_cast<std::size_t>(num_nodes), 0);
        for (int offset = 0; offset < geometry::kBlockVolume; ++offset) {
          const int node =
              (((offset >> 8) >> level) * side + (((offset >> 4) & 15) >> level)) * side + ((offset & 15) >> level);
          highest[node] = std::max<int>(highest[node], block->log_odds[offset]);
          flags[node] |= 1 << static_cast<int>(map.impl().forest.levels.of(block->log_odds[offset]));
        }
        for (int node = 0; node < num_nodes; ++node) {
          const int x = node % side;
          const int y = node / side % side;
          const int z = node / side / side;
          ASSERT_EQ(block->node_max(level, x, y, z), highest[node]);
          ASSERT_EQ(block->node_flags(level, x, y, z), flags[node]);
        }
      }
    }
    EXPECT_GT(blocks, 10);
  }
}

TEST(LocalMapProperty, CorridorEqualsBruteForce) {
  const LocalMap map = flown_map(4);
  std::mt19937 rng(9);
  int bad = 0;
  for (int trial = 0; trial < 60; ++trial) {
    const Vec3 a = random_near(map, &rng, 10.0);
    const Vec3 b = a + 0.4 * (random_near(map, &rng, 10.0) - a);
    const double radius = 0.1 + 0.02 * trial;
    int worst = 0;
    double first_bad = std::numeric_limits<double>::infinity();
    const occupancy::SegmentDistance segment(a, b);
    for_voxels(a.cwiseMin(b).array() - radius, a.cwiseMax(b).array() + radius, [&](const Index3& v) {
      const int here = badness(brute_state(map, v));
      if (here == 0) return;
      // Samples along the segment bound the true arc length from both sides to within half a step.
      const Vec3 center = geometry::center_of(v, kResolution);
      for (int i = 0; i <= 400; ++i) {
        if (segment.distance_at(i / 400.0, center, 0.5 * kResolution) > radius) continue;
        worst = std::max(worst, here);
        first_bad = std::min(first_bad, segment.length() * i / 400.0);
        break;
      }
    });
    const auto found = map.corridor_state(a, b, radius);
    ASSERT_GE(badness(found.worst), worst);
    if (!found.first_bad_m) continue;
    ++bad;
    if (worst != badness(found.worst)) continue;  // the corridor touches a voxel between two samples
    EXPECT_NEAR(*found.first_bad_m, first_bad, segment.length() / 400.0 + 0.02);
  }
  EXPECT_GT(bad, 10);
}

TEST(LocalMapProperty, BoxNearestAndRayEqualBruteForce) {
  const LocalMap map = flown_map(5);
  std::mt19937 rng(11);
  int found_any = 0;
  for (int trial = 0; trial < 100; ++trial) {
    const Vec3 a = random_near(map, &rng, 9.0);
    const Vec3 half(0.3 + 0.01 * trial, 0.5, 0.2);
    int worst = 0;
    for_voxels(a - half, a + half, [&](const Index3& v) { worst = std::max(worst, badness(brute_state(map, v))); });
    EXPECT_EQ(badness(map.box_state({a - half, a + half})), worst);

    const auto points = map.occupied_points();
    double nearest = std::numeric_limits<double>::infinity();
    for (std::size_t i = 0; i < points.size(); i += 3) {
      nearest = std::min(nearest, (Vec3(points[i], points[i + 1], points[i + 2]) - a).norm());
    }
    const auto found = map.nearest_occupied(a, 4.0);
    ASSERT_EQ(found.has_value(), nearest <= 4.0);
    if (found) {
      ++found_any;
      EXPECT_NEAR(found->distance_m, nearest, 1e-5);
    }

    const Vec3 b = random_near(map, &rng, 9.0);
    const auto ray = map.ray_cast(a, b, false);
    const double length = (b - a).norm();
    for (int i = 0; 0.01 * i < ray.range_m - 1e-6; ++i) {
      ASSERT_EQ(map.state(a + (b - a) * (0.01 * i / length)), VoxelState::kFree);
    }
    if (ray.range_m + 1e-6 >= length) continue;
    EXPECT_EQ(map.state(a + (b - a) * ((ray.range_m + 1e-6) / length)), ray.state);
  }
  EXPECT_GT(found_any, 10);
}

TEST(LocalMapProperty, RaysMissExactlyTheVoxelsOnTheirLine) {
  std::mt19937 rng(13);
  std::uniform_real_distribution<double> uniform(-9.0, 9.0);
  for (int trial = 0; trial < 200; ++trial) {
    occupancy::LocalMapConfig config;
    config.window_size_m = {30, 30, 30};
    LocalMap map(config);
    const Vec3 origin(uniform(rng), uniform(rng), uniform(rng));
    const Vec3 end = origin + Vec3(uniform(rng), uniform(rng), uniform(rng));
    const auto statistics = test::insert_from(&map, origin, {end});
    const Index3 from = geometry::index_of(origin, kResolution);
    const Index3 to = geometry::index_of(end, kResolution);
    const int steps = std::abs(to.x - from.x) + std::abs(to.y - from.y) + std::abs(to.z - from.z);
    EXPECT_EQ(statistics.cells_missed, static_cast<std::size_t>(steps));
    for (int i = 1; i < 500; ++i) {
      const Vec3 p = origin + (end - origin) * (i / 500.0);
      const Vec3 in_cell = p / kResolution - (p / kResolution).array().floor().matrix();
      if (in_cell.minCoeff() < 1e-3 || in_cell.maxCoeff() > 1.0 - 1e-3) continue;
      const double log_odds = *map.log_odds(p);
      if (geometry::index_of(p, kResolution) == to) {
        ASSERT_GT(log_odds, 0.0);
      } else {
        ASSERT_LT(log_odds, 0.0);
      }
    }
  }
}
