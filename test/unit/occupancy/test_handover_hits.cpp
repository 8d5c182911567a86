// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "scan_maker.hpp"
#include "voxnav/occupancy/local_map.hpp"

using namespace voxnav;  // NOLINT: test
using containers::VoxelState;
using geometry::Vec3;
using occupancy::LocalMap;
using occupancy::MapContent;
using occupancy::OccupiedVoxel;
using test::insert_from;

namespace {

const Vec3 kOrigin(0.2, 0.2, 0.2);

occupancy::LocalMapConfig small_config() {
  occupancy::LocalMapConfig config;
  config.window_size_m = {40, 40, 20};
  return config;
}

OccupiedVoxel leaf_at(const MapContent& content, const Vec3& p) {
  const geometry::Index3 voxel = geometry::index_of(p, content.resolution_m);
  for (const auto& block : content.blocks) {
    if (block.index != geometry::block_of(voxel)) continue;
    for (const OccupiedVoxel& leaf : block.occupied) {
      if (leaf.offset == geometry::offset_in_block(voxel)) return leaf;
    }
  }
  ADD_FAILURE() << "no occupied voxel at " << p.transpose();
  return {};
}

std::size_t num_own(const MapContent& content) {
  std::size_t count = 0;
  for (const auto& block : content.blocks) {
    for (const OccupiedVoxel& leaf : block.occupied) count += leaf.observed.hits > 0;
  }
  return count;
}

VoxelState state_at(const MapContent& content, const Vec3& p) {
  const geometry::Index3 voxel = geometry::index_of(p, content.resolution_m);
  for (const auto& block : content.blocks) {
    if (block.index == geometry::block_of(voxel)) return block.states.get(geometry::offset_in_block(voxel));
  }
  return VoxelState::kUnknown;
}

bool is_observed_free(const MapContent& content, const Vec3& p) {
  const geometry::Index3 voxel = geometry::index_of(p, content.resolution_m);
  const int offset = geometry::offset_in_block(voxel);
  for (const auto& block : content.blocks) {
    if (block.index == geometry::block_of(voxel))
      return ((block.observed_free[offset >> 6] >> (offset & 63)) & 1u) != 0;
  }
  return false;
}

/// Returns the bytes of a content without what was observed since the last handover.
std::string remembered(MapContent content) {
  for (auto& block : content.blocks) {
    block.observed_free = {};
    for (OccupiedVoxel& leaf : block.occupied) {
      leaf.observed.mean = {};
      leaf.observed.hits = 0;
      leaf.observed_time = 0;
    }
  }
  return content.to_bytes();
}

}  // namespace

TEST(HandoverHits, OnlyHitsSinceTheLastHandoverCountAsObserved) {
  const Vec3 first(5.05, 0.2, 0.2);
  const Vec3 moved(5.15, 0.2, 0.2);  // the same surface, in the same voxel, as seen from a pose that has drifted
  const Vec3 other(0.2, 6.05, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 10; ++i) insert_from(&map, kOrigin, {first, other});
  const MapContent before = map.hand_over();
  EXPECT_EQ(num_own(before), 2u);
  EXPECT_EQ(leaf_at(before, first).observed.mean, leaf_at(before, first).believed.mean);
  for (int i = 0; i < 10; ++i) insert_from(&map, kOrigin, {moved});
  const MapContent after = map.hand_over();
  EXPECT_EQ(num_own(after), 1u);
  const OccupiedVoxel leaf = leaf_at(after, moved);
  EXPECT_EQ(leaf.believed.hits, 20);
  EXPECT_EQ(leaf.observed.hits, 10);
  EXPECT_NEAR((leaf.observed.mean[0] - leaf.believed.mean[0]) * 0.4 / 254.0, 0.05, 0.003);
  EXPECT_EQ(num_own(map.content()), 0u);
}

TEST(HandoverHits, HandoversDoNotChangeTheMap) {
  LocalMap with(small_config());
  LocalMap without(small_config());
  for (unsigned i = 0; i < 60; ++i) {
    // Thin objects are hit now and then from a moving sensor; a handover must not change what the map knows of them.
    const Vec3 origin(0.2 + 0.15 * i, 0.2, 0.2);
    const auto points = test::random_points(i % 7, 400, Vec3(6.0, 0.0, 0.5), 9.0);
    insert_from(&with, origin, points);
    insert_from(&without, origin, points);
    if (i % 5 == 4) with.hand_over();
  }
  EXPECT_EQ(remembered(with.content()), remembered(without.content()));
  EXPECT_LT(num_own(with.content()), num_own(without.content()));
  EXPECT_EQ(with.centers_above(0.5), without.centers_above(0.5));
  EXPECT_EQ(with.centers_below(0.3), without.centers_below(0.3));
}

TEST(HandoverHits, HaveTheirMeanTime) {
  const Vec3 early(5.05, 0.2, 0.2);
  const Vec3 late(0.2, 6.05, 0.2);
  const Vec3 always(0.2, -6.05, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 100; ++i) {
    if (i == 0) map.hand_over();
    insert_from(&map, kOrigin, {always, i < 20 ? early : late});
  }
  const MapContent content = map.hand_over();
  EXPECT_NEAR(leaf_at(content, early).observed_time, 0.1 * 255, 2);
  EXPECT_NEAR(leaf_at(content, late).observed_time, 0.6 * 255, 2);
  EXPECT_NEAR(leaf_at(content, always).observed_time, 0.5 * 255, 2);
}

TEST(HandoverHits, CountersSaturate) {
  const Vec3 p(5.05, 0.2, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 400; ++i) insert_from(&map, kOrigin, {p});
  map.hand_over();
  for (int i = 0; i < 3; ++i) insert_from(&map, kOrigin, {p});
  EXPECT_EQ(leaf_at(map.content(), p).believed.hits, 255);
  EXPECT_EQ(leaf_at(map.content(), p).observed.hits, 3);
}

TEST(HandoverHits, EvictedContentKeepsItsObservedHits) {
  const Vec3 seen(5.05, 0.2, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 5; ++i) insert_from(&map, kOrigin, {seen});
  map.hand_over();
  for (int i = 0; i < 4; ++i) insert_from(&map, kOrigin, {seen});
  insert_from(&map, Vec3(60.2, 0.2, 0.2), {});
  EXPECT_EQ(leaf_at(map.take_evicted(), seen).observed.hits, 4);
}

TEST(HandoverFree, OnlyVoxelsCrossedSinceTheLastHandoverCountAsObserved) {
  const Vec3 first(5.05, 0.2, 0.2);
  const Vec3 other(0.2, 6.05, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 10; ++i) insert_from(&map, kOrigin, {first, other});
  const MapContent before = map.hand_over();
  EXPECT_TRUE(is_observed_free(before, {3.0, 0.2, 0.2}));
  EXPECT_TRUE(is_observed_free(before, {0.2, 3.0, 0.2}));
  insert_from(&map, kOrigin, {first});
  const MapContent after = map.hand_over();
  EXPECT_TRUE(is_observed_free(after, {3.0, 0.2, 0.2}));
  EXPECT_FALSE(is_observed_free(after, {0.2, 3.0, 0.2}));
  EXPECT_EQ(state_at(after, {0.2, 3.0, 0.2}), VoxelState::kFree);  // the voxel is remembered as free
  EXPECT_FALSE(is_observed_free(map.content(), {3.0, 0.2, 0.2}));
}

TEST(HandoverFree, DoesNotHoldVoxelsThatWereHitButAreFreeByOlderScans) {
  const Vec3 place(3.0, 0.2, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 30; ++i) insert_from(&map, kOrigin, {{5.05, 0.2, 0.2}});
  map.hand_over();
  insert_from(&map, kOrigin, {place});
  const MapContent content = map.hand_over();
  ASSERT_EQ(state_at(content, place), VoxelState::kFree);
  EXPECT_FALSE(is_observed_free(content, place));
  EXPECT_TRUE(is_observed_free(content, {2.0, 0.2, 0.2}));
}

TEST(HandoverFree, HoldsMarkedVoxelsAndIsKeptByEvictedContent) {
  const Vec3 marked(2.0, 2.0, 0.2);
  const Vec3 seen(5.05, 0.2, 0.2);
  LocalMap map(small_config());
  for (int i = 0; i < 5; ++i) insert_from(&map, kOrigin, {seen});
  map.mark_free(marked, 0.5);
  map.hand_over();
  map.mark_free(marked, 0.5);  // the voxels are free already, but this counts as a new observation
  for (int i = 0; i < 5; ++i) insert_from(&map, kOrigin, {seen});
  EXPECT_TRUE(is_observed_free(map.content(), marked));
  insert_from(&map, Vec3(60.2, 0.2, 0.2), {});
  const MapContent evicted = map.take_evicted();
  EXPECT_TRUE(is_observed_free(evicted, marked));
  EXPECT_TRUE(is_observed_free(evicted, {3.0, 0.2, 0.2}));
}

TEST(HandoverFree, IsKeptWhenTheMapIsSaved) {
  LocalMap map(small_config());
  for (int i = 0; i < 10; ++i) insert_from(&map, kOrigin, {{5.05, 0.2, 0.2}, {0.2, 6.05, 0.2}});
  map.hand_over();
  insert_from(&map, kOrigin, {{5.05, 0.2, 0.2}});
  EXPECT_EQ(LocalMap::from_bytes(map.to_bytes()).content().to_bytes(), map.content().to_bytes());
}
