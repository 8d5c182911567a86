// SPDX-License-Identifier: BSD-3-Clause
// What becomes of new and moving voxels of which a map has no more room.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <vector>

#include "voxnav/occupancy/local_map.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using geometry::Vec3f;
using geometry::view_of;
using occupancy::LocalMap;

namespace {

constexpr std::size_t kMaxNewOfBlock = 256, kMaxMoving = 20000;

/// A map that believes a ball around its sensor to be free.
LocalMap free_map() {
  occupancy::LocalMapConfig config;
  config.window_size_m = {44, 44, 44};
  config.num_threads = 1;
  LocalMap map(config);
  map.mark_free(Vec3::Zero(), 20.0);
  return map;
}

/// The centres of all voxels whose coordinates are within a size of those of the sensor, but for the nearest ones.
std::vector<Vec3f> cube_of_points(int half_size) {
  std::vector<Vec3f> points;
  for (int x = -half_size; x < half_size; ++x) {
    for (int y = -half_size; y < half_size; ++y) {
      for (int z = -half_size; z < half_size; ++z) {
        const Vec3f p(0.4f * (static_cast<float>(x) + 0.5f), 0.4f * (static_cast<float>(y) + 0.5f),
                      0.4f * (static_cast<float>(z) + 0.5f));
        if (p.norm() > 2.0f) points.push_back(p);
      }
    }
  }
  return points;
}

/// The number of points beyond those that each block remembers.
std::size_t num_too_many(const std::vector<Vec3f>& points) {
  std::map<std::vector<int>, std::size_t> of_block;
  for (const Vec3f& p : points) {
    const geometry::Index3 block = geometry::block_of(geometry::index_of(p.cast<double>(), 0.4));
    ++of_block[{block.x, block.y, block.z}];
  }
  std::size_t count = 0;
  for (const auto& [block, number] : of_block) count += number > kMaxNewOfBlock ? number - kMaxNewOfBlock : 0;
  return count;
}

std::vector<geometry::Index3> new_voxels(const LocalMap& map) {
  std::vector<geometry::Index3> out;
  for (const occupancy::NewHit& hit : map.new_hits()) out.push_back(hit.voxel);
  return out;
}

TEST(NewVoxels, ThoseBeyondTheRoomOfTheirBlockAreCounted) {
  LocalMap map = free_map();
  const std::vector<Vec3f> points = cube_of_points(8);
  ASSERT_GT(num_too_many(points), 0u);
  const occupancy::InsertStatistics statistics = map.insert(view_of(points), geometry::Pose::Identity());
  EXPECT_EQ(statistics.cells_hit, points.size());
  EXPECT_EQ(statistics.new_not_kept, num_too_many(points));
  EXPECT_EQ(map.num_new_not_kept(), num_too_many(points));
  EXPECT_EQ(map.new_hits().size() + num_too_many(points), points.size());
}

TEST(NewVoxels, NothingIsCountedWhereThereIsRoom) {
  LocalMap map = free_map();
  std::vector<Vec3f> points = cube_of_points(8);
  points.resize(kMaxNewOfBlock);
  map.insert(view_of(points), geometry::Pose::Identity());
  EXPECT_EQ(map.new_hits().size(), points.size());
  EXPECT_EQ(map.num_new_not_kept(), 0u);
}

TEST(NewVoxels, HitsOfThoseLeftOutCountAsAnyOther) {
  LocalMap map = free_map();
  const std::vector<Vec3f> points = cube_of_points(8);
  for (int i = 0; i < 4; ++i) map.insert(view_of(points), geometry::Pose::Identity());
  const auto is_occupied = [&](const Vec3f& p) { return map.state(p.cast<double>()) == VoxelState::kOccupied; };
  EXPECT_TRUE(std::all_of(points.begin(), points.end(), is_occupied));
}

TEST(NewVoxels, MovingVoxelsBeyondTheNumberThatIsRememberedAreCounted) {
  LocalMap map = free_map();
  const std::vector<Vec3f> points = cube_of_points(35);
  map.insert(view_of(points), geometry::Pose::Identity());
  const std::vector<geometry::Index3> found = new_voxels(map);
  ASSERT_GT(found.size(), kMaxMoving);
  map.mark_moving({found.begin(), found.begin() + kMaxMoving});
  EXPECT_EQ(map.num_moving_not_kept(), 0u);
  map.mark_moving(found);  // those that are marked already count no more
  EXPECT_EQ(map.num_moving_not_kept(), found.size() - kMaxMoving);
}

}  // namespace
