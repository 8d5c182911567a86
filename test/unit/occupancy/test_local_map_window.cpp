// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "occupancy/local_map_impl.hpp"
#include "scan_maker.hpp"
#include "steps.hpp"

using namespace voxnav;  // NOLINT: test
using containers::StateGrid;
using containers::VoxelState;
using geometry::Vec3;
using occupancy::LocalMap;
using occupancy::LocalMapConfig;
using test::insert_from;

namespace {

LocalMapConfig small_config() {
  LocalMapConfig config;
  config.window_size_m = {30, 30, 20};
  config.max_range_m = 12.0;
  return config;
}

void fly(LocalMap* map, int scans, double step) {
  for (int i = 0; i < scans; ++i) {
    const Vec3 origin(step * i, 0.3 * step * i, 1.0);
    insert_from(map, origin, test::random_points(static_cast<unsigned>(i) / 3, 300, origin, 9.0));
  }
}

}  // namespace

TEST(LocalMapWindow, EvictedContentIsReturnedOnce) {
  LocalMapConfig config = small_config();
  LocalMap map(config);
  const Vec3 origin(0.2, 0.2, 0.2);
  const Vec3 post(5.0, 0.2, 0.2);
  for (int i = 0; i < 3; ++i) insert_from(&map, origin, {post});
  const auto away = insert_from(&map, Vec3(30.2, 0.2, 0.2), {});
  EXPECT_GT(away.cells_evicted, 0u);
  EXPECT_FALSE(away.window_cleared);
  EXPECT_EQ(map.state(post), VoxelState::kUnknown);
  const occupancy::MapContent out = map.take_evicted();
  ASSERT_EQ(out.num_occupied(), 1u);
  for (const auto& block : out.blocks) {
    for (const auto& leaf : block.occupied) {
      EXPECT_LT((occupancy::surface_point(block.index, leaf, out.resolution_m).cast<double>() - post).norm(), 0.01);
    }
  }
  EXPECT_TRUE(map.take_evicted().blocks.empty());
}

TEST(LocalMapWindow, HoveringAcrossABlockBorderEvictsNothing) {
  LocalMap map(small_config());
  insert_from(&map, Vec3(6.3, 0.2, 0.2), test::random_points(1, 300, Vec3(6.3, 0.2, 0.2), 9.0));
  std::size_t evicted = 0;
  for (int i = 0; i < 20; ++i) evicted += insert_from(&map, Vec3(i % 2 ? 6.3 : 6.5, 0.2, 0.2), {}).blocks_evicted;
  EXPECT_EQ(evicted, 0u);
}

TEST(LocalMapWindow, AJumpClearsTheMapAndEvictsEverything) {
  LocalMap map(small_config());
  fly(&map, 5, 0.3);
  const auto known = map.content();
  ASSERT_GT(known.num_occupied(), 10u);
  map.take_evicted();
  const auto statistics = insert_from(&map, Vec3(1000, 0, 0), {});
  EXPECT_TRUE(statistics.window_cleared);
  EXPECT_EQ(map.take_evicted().to_bytes(), known.to_bytes());
  EXPECT_TRUE(map.content().blocks.empty());
}

TEST(LocalMapWindow, EvictedBlocksAreBoundedAndDropsCounted) {
  LocalMapConfig config = small_config();
  config.max_evicted_blocks = 3;
  LocalMap map(config);
  fly(&map, 40, 2.0);
  EXPECT_EQ(map.num_evicted_pending(), 3u);
  EXPECT_GT(map.num_evicted_dropped(), 0u);
}

TEST(LocalMapWindow, WindowCoversItsSize) {
  const LocalMapConfig config = small_config();
  for (const double shift : test::steps(0.0, 13.0, 0.7)) {
    LocalMap map(config);
    insert_from(&map, Vec3(0.1, 0.1, 0.1), {});
    insert_from(&map, Vec3(shift, 0.1, 0.1), {});
    for (const double side : {-1.0, 1.0}) {
      const Vec3 p(shift + side * 14.9, 0.1, 0.1);
      EXPECT_TRUE(map.impl().forest.contains(p)) << shift;
    }
  }
}

TEST(LocalMapWindow, ChangesRebuildTheMapElsewhere) {
  LocalMap map(small_config());
  StateGrid mirror(map.config().resolution_m);
  for (int i = 0; i < 30; ++i) {
    const Vec3 origin(1.5 * i, 0.0, 1.0);
    insert_from(&map, origin, test::random_points(static_cast<unsigned>(i) / 3, 300, origin, 9.0));
    if (i == 20) map.clear();
    if (i % 4 != 0) containers::apply(map.take_changes(), &mirror);
  }
  containers::apply(map.take_changes(), &mirror);
  StateGrid whole(map.config().resolution_m);
  containers::apply(map.snapshot(), &whole);
  ASSERT_EQ(mirror.sorted_block_indices(), whole.sorted_block_indices());
  for (const auto& [index, block] : whole.blocks()) EXPECT_EQ(block.words, mirror.find_block(index)->words);
}

TEST(LocalMapWindow, TwoReadersFollowByChangesAlone) {
  LocalMap map(small_config());
  StateGrid often(0.4), seldom(0.4);
  std::uint64_t often_at = 0, seldom_at = 0;
  for (int i = 0; i < 24; ++i) {
    const Vec3 origin(1.5 * i, 0.5 * i, 1.0);
    insert_from(&map, origin, test::random_points(static_cast<unsigned>(i) / 3, 300, origin, 9.0));
    if (i == 15) map.set_thresholds(0.4, 0.7);
    const containers::GridUpdate update = map.changes_since(often_at);
    EXPECT_EQ(update.is_snapshot, i == 0);
    containers::apply(update, &often);
    often_at = map.sequence();
    if (i % 7 != 6) continue;
    containers::apply(map.changes_since(seldom_at), &seldom);
    seldom_at = map.sequence();
    EXPECT_EQ(containers::snapshot_of(seldom).states, map.snapshot().states);
  }
  EXPECT_EQ(containers::snapshot_of(often).block_indices, map.snapshot().block_indices);
  EXPECT_EQ(containers::snapshot_of(often).states, map.snapshot().states);
  EXPECT_TRUE(map.changes_since(map.sequence()).block_indices.empty());
  EXPECT_TRUE(map.changes_since(map.sequence() + 1).is_snapshot) << "a sequence of another map";
  map.clear();
  containers::apply(map.changes_since(often_at), &often);
  EXPECT_TRUE(containers::snapshot_of(often).block_indices.empty());
}
