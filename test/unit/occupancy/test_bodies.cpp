// SPDX-License-Identifier: BSD-3-Clause
// Bodies of other vehicles, of which it is known where they are, are not mapped.
#include <gtest/gtest.h>

#include <limits>

#include "scan_maker.hpp"
#include "voxnav/occupancy/local_map.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using occupancy::LocalMap;
using test::insert_from;

namespace {

const Vec3 kOrigin(0.2, 0.2, 0.2), kBody(5.0, 0.2, 0.2), kBehind(10.0, 0.2, 0.2);

LocalMap small_map() {
  occupancy::LocalMapConfig config;
  config.window_size_m = {40, 40, 20};
  return LocalMap(config);
}

void insert(LocalMap* map, const Vec3& seen, int times) {
  for (int i = 0; i < times; ++i) insert_from(map, kOrigin, {seen});
}

TEST(Bodies, AreNotMappedInFreeSpace) {
  LocalMap map = small_map();
  insert(&map, kBehind, 20);
  ASSERT_EQ(map.state(kBody), VoxelState::kFree);
  map.set_bodies({{kBody, 1.0}});
  insert(&map, kBody, 20);
  EXPECT_EQ(map.state(kBody), VoxelState::kFree);
  ASSERT_EQ(map.new_hits().size(), 1u) << "the planner sees it nevertheless";
  map.set_bodies({});
  insert(&map, kBehind, 1);
  EXPECT_EQ(map.state(kBody), VoxelState::kFree) << "nothing is left behind";
}

/// A wrong free would be flown into: what is hit in a body is left unknown, whatever passes through its voxel.
TEST(Bodies, LeaveUnknownSpaceUnknown) {
  LocalMap map = small_map();
  map.set_bodies({{kBody, 1.0}});
  for (int i = 0; i < 20; ++i) insert_from(&map, kOrigin, {kBody, Vec3(10.0, 0.22, 0.22)});
  EXPECT_EQ(map.state(kBody), VoxelState::kUnknown);
  EXPECT_EQ(map.state(Vec3(3.0, 0.2, 0.2)), VoxelState::kFree) << "the way up to it was seen";
  EXPECT_EQ(map.state(kBehind), VoxelState::kOccupied) << "what lies beyond the ball is mapped";
}

TEST(Bodies, LeaveWhatWasThereBefore) {
  LocalMap map = small_map();
  insert(&map, kBody, 10);
  ASSERT_EQ(map.state(kBody), VoxelState::kOccupied);
  map.set_bodies({{kBody, 1.0}});
  insert(&map, kBody, 20);
  EXPECT_EQ(map.state(kBody), VoxelState::kOccupied);
}

TEST(Bodies, AThingInTheirPlaceIsMappedOnceTheyAreGone) {
  LocalMap map = small_map();
  map.set_bodies({{kBody, 1.0}});
  insert(&map, kBody, 10);
  ASSERT_NE(map.state(kBody), VoxelState::kOccupied);
  map.set_bodies({});
  insert(&map, kBody, 4);
  EXPECT_EQ(map.state(kBody), VoxelState::kOccupied);
}

TEST(Bodies, ThatAreNotFiniteAreRefused) {
  LocalMap map = small_map();
  EXPECT_THROW(map.set_bodies({{Vec3(0, std::numeric_limits<double>::quiet_NaN(), 0), 1.0}}), std::invalid_argument);
  EXPECT_THROW(map.set_bodies({{kBody, -1.0}}), std::invalid_argument);
}

}  // namespace
