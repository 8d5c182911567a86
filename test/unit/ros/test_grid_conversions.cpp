// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include "voxnav/containers/state_grid.hpp"
#include "voxnav_ros/conversions.hpp"
#include "voxnav_ros/grid_conversions.hpp"
#include "voxnav_ros/messages.hpp"

using namespace voxnav_ros;  // NOLINT: test
namespace containers = voxnav::containers;

namespace {

containers::GridUpdate example() {
  containers::GridUpdate update;
  update.is_snapshot = true;
  update.block_indices = {1, -2, 3};
  update.removed_block_indices = {4, 5, -6, 7, 8, 9};
  update.states = {1, 2, 3, 4};
  return update;
}

}  // namespace

TEST(GridConversions, AnUpdateComesBackAsItWas) {
  const containers::GridUpdate update = example();
  const containers::GridUpdate back = from_msg(to_msg(update, {"map", 5, 6, 0.4}));
  EXPECT_EQ(back.is_snapshot, update.is_snapshot);
  EXPECT_EQ(back.block_indices, update.block_indices);
  EXPECT_EQ(back.removed_block_indices, update.removed_block_indices);
  EXPECT_EQ(back.states, update.states);
}

TEST(GridConversions, TheMessageHoldsFrameStampAndSequence) {
  const msg::GridUpdate msg = to_msg(example(), {"uav1/voxnav_map", 1500000001LL, 42, 0.25});
  EXPECT_EQ(msg.header.frame_id, "uav1/voxnav_map");
  EXPECT_EQ(to_ns(msg.header.stamp), 1500000001LL);
  EXPECT_EQ(msg.sequence, 42u);
  EXPECT_DOUBLE_EQ(msg.resolution_m, 0.25);
  EXPECT_TRUE(msg.is_snapshot);
}

TEST(GridConversions, ListsOfWrongLengthAreRefusedByTheGrid) {
  containers::GridUpdate update = example();
  update.block_indices.push_back(0);
  const containers::GridUpdate back = from_msg(to_msg(update, {"map", 0, 0, 0.4}));
  containers::StateGrid grid(0.4);
  EXPECT_ANY_THROW(containers::apply(back, &grid));
}

TEST(GridConversions, SightingsAreHitsThatAreStillFreeAndWhatMoves) {
  voxnav::occupancy::NewHit hit;
  hit.voxel = {1, -2, 3};
  hit.num_points = 7;
  voxnav::occupancy::NewHit known = hit;
  known.state = containers::VoxelState::kOccupied;
  containers::MovingThing thing;
  thing.id = 5;
  thing.position = {1.0, 2.0, 3.0};
  thing.velocity = {0.5, -1.0, 0.0};
  thing.velocity_sigma_mps = 0.25;
  msg::GridUpdate msg;
  add_sightings({hit, known}, {thing}, &msg);
  EXPECT_EQ(msg.new_hits, (std::vector<std::int32_t>{1, -2, 3}));
  EXPECT_EQ(msg.new_hit_returns, (std::vector<std::uint16_t>{7}));
  ASSERT_EQ(msg.moving_things.size(), 1u);
  EXPECT_EQ(msg.moving_things[0].id, 5u);
  EXPECT_EQ(msg.moving_things[0].position.z, 3.0);
  EXPECT_EQ(msg.moving_things[0].velocity.y, -1.0);
  EXPECT_EQ(msg.moving_things[0].velocity_sigma_mps, 0.25);
}
